// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// What holds of every device that sends a stream of bytes, whatever it speaks: how the stream is cut, where
// it is joined, what is missing of it, damaged or sent again. Streams of simulated devices, and recorded
// ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "drivers/capture/pcap_source.h"
#include "drivers/hokuyo/uam_frame.h"
#include "test/drivers/hokuyo/scip_bench.h"
#include "test/drivers/sick/cola/cola_bench.h"
#include "test/drivers/sick/compact/segment_bench.h"
#include "test/sim/devices/uam_device.h"
#include "test/support/allocations.h"
#include "test/support/captures.h"

namespace lidard::test {
namespace {

using namespace std::chrono_literals;
constexpr Stamp epoch{1'767'225'600'000'000'000};

template <class Bytes>
void append(std::string& stream, const Bytes& bytes) {
  stream.append(bytes.begin(), bytes.end());
}

/// Scans of one model, whose planes come in turn.
std::string cola_stream(sim::Cola dialect, int scans, const std::vector<std::int16_t>& layers = {0}) {
  std::string stream;
  sim::SickScan sample;
  sample.encoders = {{1, 1}};
  sample.measurement_frequency = layers.size() > 1 ? 180 : 360;
  for (int i = 0; i < scans; ++i) {
    sample.layer = layers[static_cast<std::size_t>(i) % layers.size()];
    sample.telegram_counter = sample.scan_counter = static_cast<std::uint16_t>(i);
    sample.start_us = static_cast<std::uint32_t>(1'000'000 + 20'000 * i);
    sample.transmit_us = sample.start_us + 3000;
    sample.channels = {channel("DIST1", std::vector<std::uint16_t>(61, static_cast<std::uint16_t>(900 + i))),
                       channel("RSSI1", std::vector<std::uint16_t>(61, 200), false)};
    append(stream, sample.bytes(dialect));
  }
  return stream;
}

std::string answers_of(sim::TcpDevice& device, const std::string& request, Span time) {
  device.connected(epoch);
  device.receive(request, epoch);
  std::string stream;
  while (const auto sent = device.next(epoch + time)) stream += sent->bytes;
  return stream;
}
std::string scip_stream(const std::string& request, Span time) {
  sim::ScipDeviceOptions options;
  options.knows_echoes = true;
  std::vector<sim::ScipStep> steps = scip_wall(1081);
  for (std::size_t i = 0; i < steps.size(); i += 3) steps[i].push_back({5000, 7});
  sim::ScipDevice device(
      options, [&](Stamp) { return steps; }, epoch - 100s);
  return answers_of(device, request + "\n", time);
}
std::string uam_stream(const std::string& command, Span time) {
  sim::UamDevice device(
      {},
      [](Stamp, std::size_t beams) {
        return std::vector<sim::UamBeam>(beams, {1500, 100});
      },
      epoch - 100s);
  return answers_of(device, hokuyo::uam_request(command), time);
}
std::string segment_stream(std::uint64_t frames) {
  const SegmentBench bench("sick_lrs4000");
  std::string stream;
  for (std::uint64_t f = 0; f < frames; ++f)
    for (int i = 0; i < SegmentBench::segments; ++i) append(stream, bench.encode(bench.segment(f, i)));
  return stream;
}

struct Stream {
  const char* name;
  const char* model;
  std::string (*bytes)(Span time);
  bool has_checksum = true, counts_losses = true;
};

const Stream streams[] = {
    {"ColaB", "sick_lms5xx",
     [](Span time) { return cola_stream(sim::Cola::binary, static_cast<int>(time / 20ms)); }},
    {"ColaA", "sick_lms5xx",
     [](Span time) { return cola_stream(sim::Cola::text, static_cast<int>(time / 20ms)); }, false},
    {"ColaPlanes", "sick_mrs1000",
     [](Span time) {
       return cola_stream(sim::Cola::binary, static_cast<int>(time / 20ms), {250, -500, 0, -250});
     }},
    {"Scip", "hokuyo_ust_10lx", [](Span time) { return scip_stream("ME0100012001000;user", time); }, true,
     false},
    {"ScipEchoes", "hokuyo_utm_30lx_ew", [](Span time) { return scip_stream("NE0100016001000", time); }, true,
     false},
    {"Uam", "hokuyo_uam_05lp", [](Span time) { return uam_stream("AR02", time); }, true, false},
    {"UamIntensities", "hokuyo_uam_05lp_intensity", [](Span time) { return uam_stream("AR04", time); }, true,
     false},
    {"Compact", "sick_lrs4000",
     [](Span time) { return segment_stream(static_cast<std::uint64_t>(time / 50ms)); }}};

/// A driver, and what came of the parts of a stream that it was given.
class Player final : public FrameReceiver {
 public:
  Player(const char* model, const std::string& stream, Span time) : stream_(stream), time_(time) {
    DriverConfig config;
    config.model = find_model(model);
    config.publish_multiecho = true;
    driver = config.model->make(config);
  }
  void scan(PlanarScan& scan) override {
    std::vector<float> values = scan.ranges;
    for (float& value : values) value = std::isnan(value) ? -1 : value;  // NaN is not equal to itself
    frames.push_back(values);
  }
  void cloud(Cloud& cloud) override {
    std::vector<float> values;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const CloudPoint p = cloud.points()[i];
      values.insert(values.end(), {p.x, p.y, p.z});
    }
    frames.push_back(values);
  }
  Reject give(std::size_t begin, std::size_t end, std::uint64_t missing = 0) {
    Packet packet;
    packet.transport = Transport::tcp;
    packet.payload = ByteView(std::string_view(stream_).substr(begin, end - begin));
    packet.arrival = epoch + span_from_seconds(seconds(time_) * static_cast<double>(end) /
                                               static_cast<double>(stream_.size()));
    packet.stream_start = std::exchange(is_first_, false);
    packet.missing = missing;
    return driver->receive(packet, *this).reject;
  }
  void give_in_pieces(std::size_t size) {
    for (std::size_t at = 0; at < stream_.size(); at += size) give(at, std::min(stream_.size(), at + size));
  }
  void connect_anew() {
    driver->disconnected();
    is_first_ = true;
  }
  const Counters& counters() const { return driver->counters(); }

  std::unique_ptr<Driver> driver;
  std::vector<std::vector<float>> frames;

 private:
  const std::string& stream_;
  Span time_;
  bool is_first_ = true;
};

/// Where the scan telegrams of a stream end.
std::vector<std::size_t> ends_of(const char* model, const std::string& stream, Span time) {
  Player player(model, stream, time);
  std::vector<std::size_t> ends;
  for (std::size_t at = 0; at < stream.size(); ++at) {
    player.give(at, at + 1);
    if (player.counters().packets > ends.size()) ends.push_back(at + 1);
  }
  return ends;
}

/// The frames are the last ones of all, but for a first one that is not whole.
void expect_last_of(const std::vector<std::vector<float>>& frames,
                    const std::vector<std::vector<float>>& all) {
  ASSERT_LE(frames.size(), all.size());
  if (!frames.empty()) {
    EXPECT_TRUE(std::equal(frames.rbegin(), frames.rend() - 1, all.rbegin()));
  }
}

/// The stream of a simulated device: nothing but scans, and at its begin what it was asked for.
class EveryStream : public ::testing::TestWithParam<Stream> {
 protected:
  static constexpr Span time = 300ms;
  EveryStream() { whole.give(0, bytes.size()); }
  Player player() const { return {GetParam().model, bytes, time}; }
  std::size_t begin_of(std::size_t telegram) const { return telegram == 0 ? 0 : ends[telegram - 1]; }

  const std::string bytes = GetParam().bytes(time);
  const std::vector<std::size_t> ends = ends_of(GetParam().model, bytes, time);
  const std::size_t step = std::max<std::size_t>(1, bytes.size() / 1000);
  Player whole = player();
};

TEST_P(EveryStream, GivesTheSameFramesHoweverItIsCut) {
  ASSERT_GE(ends.size(), 8U);
  ASSERT_GE(whole.frames.size(), 2U);
  EXPECT_EQ(whole.counters().packets, ends.size());
  EXPECT_EQ(whole.counters().rejected_total() + whole.counters().lost_packets, 0U);
  for (std::size_t cut = 0; cut <= bytes.size(); cut += step) {
    Player halves = player();
    halves.give(0, cut);
    halves.give(cut, bytes.size());
    ASSERT_TRUE(halves.frames == whole.frames) << cut;
    ASSERT_EQ(halves.counters().rejected_total(), 0U) << cut;
  }
  for (const std::size_t size : {1U, 2U, 3U, 7U, 64U, 65U, 1000U, 1448U}) {
    Player pieces = player();
    pieces.give_in_pieces(size);
    ASSERT_TRUE(pieces.frames == whole.frames) << size;
  }
}

TEST_P(EveryStream, JoinedAtAnyByteGivesWhatFollows) {
  for (std::size_t cut = 0; cut < bytes.size(); cut += step) {
    Player joined = player();
    joined.give(cut, bytes.size());
    std::size_t following = 0;
    for (std::size_t i = 0; i < ends.size(); ++i) following += begin_of(i) >= cut ? 1 : 0;
    // What stands before the first telegram is an answer.
    ASSERT_GE(joined.counters().packets, following) << cut;
    ASSERT_LE(joined.counters().packets, following + (cut < ends[0] ? 1 : 0)) << cut;
    ASSERT_EQ(joined.counters().rejected_total(), 0U) << cut;
    expect_last_of(joined.frames, whole.frames);
  }
}

TEST_P(EveryStream, AHoleCostsTheTelegramsThatItHit) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    std::mt19937 random(seed);
    const std::size_t from = ends[1] + random() % (ends[ends.size() - 3] - ends[1]);
    const std::size_t to = std::min(bytes.size(), from + 1 + random() % (2 * ends[1]));
    Player holed = player();
    holed.give(0, from);
    holed.give(to, bytes.size(), to - from);
    std::size_t intact = 0;
    for (std::size_t i = 0; i < ends.size(); ++i) intact += ends[i] <= from || begin_of(i) >= to ? 1 : 0;
    EXPECT_EQ(holed.counters().packets, intact) << seed;
    EXPECT_EQ(holed.counters().rejected_total(), 0U) << seed;
    if (GetParam().counts_losses && to <= begin_of(ends.size() - 1)) {
      EXPECT_EQ(holed.counters().lost_packets, ends.size() - intact) << seed;
    }
  }
}

TEST_P(EveryStream, ADamagedTelegramCostsItselfAlone) {
  if (!GetParam().has_checksum) return;
  std::string damaged = bytes;
  const std::size_t middle = ends.size() / 2;
  char& byte = damaged[(begin_of(middle) + ends[middle]) / 2];
  byte = byte == '0' ? '1' : '0';
  Player spoiled(GetParam().model, damaged, time);
  spoiled.give(0, damaged.size());
  EXPECT_EQ(spoiled.counters().rejected[static_cast<std::size_t>(Reject::checksum)], 1U);
  EXPECT_EQ(spoiled.counters().rejected_total(), 1U);
  EXPECT_GE(spoiled.frames.size() + 1, whole.frames.size());
}

TEST_P(EveryStream, WhatComesTwiceIsCountedAndNotPublishedAgain) {
  Player twice = player();
  for (std::size_t i = 0; i < ends.size(); ++i) {
    EXPECT_EQ(twice.give(begin_of(i), ends[i]), Reject::none);
    EXPECT_EQ(twice.give(begin_of(i), ends[i]), Reject::duplicate) << i;
  }
  twice.give(ends.back(), bytes.size());
  EXPECT_TRUE(twice.frames == whole.frames);
  EXPECT_EQ(twice.counters().rejected[static_cast<std::size_t>(Reject::duplicate)], ends.size());
  EXPECT_EQ(twice.counters().lost_packets, 0U);
}

TEST_P(EveryStream, OfANewConnectionForgetsHalfATelegramOfTheFormerOne) {
  Player both = player();
  const std::size_t middle = ends.size() / 2;
  both.give(0, (begin_of(middle) + ends[middle]) / 2);
  both.connect_anew();
  EXPECT_EQ(both.counters().incomplete, 1U);
  both.give(ends[middle], bytes.size());
  EXPECT_EQ(both.counters().packets, ends.size() - 1);
  EXPECT_EQ(both.counters().rejected_total(), 0U);
}

TEST_P(EveryStream, IsDecodedWithoutAnAllocationOnceWarm) {
  const std::string longer = GetParam().bytes(2s);
  DriverConfig config;
  config.model = find_model(GetParam().model);
  config.frame_id = "a_rather_long_name_of_a_frame_id";
  config.publish_multiecho = true;
  const auto driver = config.model->make(config);
  Counted out;
  Packet packet;
  packet.transport = Transport::tcp;
  std::uint64_t before = 0;
  for (const Stamp begin : {epoch, epoch + 5s}) {
    for (std::size_t at = 0; at + 1448 < longer.size(); at += 1448) {
      if (begin > epoch && at > longer.size() / 4 && before == 0) before = allocations();
      packet.payload = ByteView(std::string_view(longer).substr(at, 1448));
      packet.stream_start = at == 0;
      packet.arrival =
          begin + span_from_seconds(2.0 * static_cast<double>(at) / static_cast<double>(longer.size()));
      driver->receive(packet, out);
    }
  }
  EXPECT_GE(out.scans + out.clouds, 40U);
  EXPECT_EQ(allocations() - before, 0U);
}

INSTANTIATE_TEST_SUITE_P(Simulated, EveryStream, ::testing::ValuesIn(streams),
                         [](const auto& each) { return std::string(each.param.name); });

struct Recorded {
  const char* capture;
  const char* model;
};

/// A recorded connection, with answers between the scans and scans that the device sent twice.
class RecordedStream : public ::testing::TestWithParam<Recorded> {};

TEST_P(RecordedStream, GivesTheSameFramesHoweverItIsCutAndWhereverItIsJoined) {
  LIDARD_NEED_CAPTURE(path, std::string("sick/") + GetParam().capture + ".pcap");
  std::string stream;
  PcapSource source(path);
  for (Packet packet; source.next(packet);)
    if (packet.transport == Transport::tcp && packet.from.port == 2112) stream += packet.payload.text();
  constexpr Span time = 4s;
  Player whole(GetParam().model, stream, time);
  whole.give(0, stream.size());
  ASSERT_GE(whole.frames.size(), 20U);
  for (const std::size_t size : {11U, 100U, 1448U, 9000U, 70000U}) {
    Player pieces(GetParam().model, stream, time);
    pieces.give_in_pieces(size);
    EXPECT_TRUE(pieces.frames == whole.frames) << size;
    EXPECT_EQ(pieces.counters().rejected_total(), whole.counters().rejected_total());
  }
  // Two telegrams around the middle, in which the listener starts.
  for (std::size_t join = stream.size() / 2; join < stream.size() / 2 + 4000; join += 7) {
    Player joined(GetParam().model, stream, time);
    joined.give(join, stream.size());
    ASSERT_GE(joined.frames.size(), whole.frames.size() / 2 - 5);
    expect_last_of(joined.frames, whole.frames);
    EXPECT_EQ(joined.counters().rejected[static_cast<std::size_t>(Reject::duplicate)],
              joined.counters().rejected_total());
    EXPECT_LE(joined.counters().incomplete, 1U);
  }
  std::mt19937 random(5);
  const std::uint64_t all = whole.counters().packets;
  for (int trial = 0; trial < 20; ++trial) {
    const std::size_t from = stream.size() / 4 + random() % (stream.size() / 2), size = 1 + random() % 20000;
    Player holed(GetParam().model, stream, time);
    holed.give(0, from);
    holed.give(from + size, stream.size(), size);
    const Counters& counters = holed.counters();
    EXPECT_LE(counters.lost_packets + counters.packets, all + 3) << "a repeated telegram hides a loss";
    EXPECT_GE(counters.lost_packets + counters.packets + 12, all);
  }
}

INSTANTIATE_TEST_SUITE_P(Sick, RecordedStream,
                         ::testing::Values(Recorded{"lms111_colab_20210302", "sick_lms1xx"},
                                           Recorded{"lms511_colab_20210301", "sick_lms5xx"},
                                           Recorded{"tim781s_colab_20210125", "sick_tim7xxs"},
                                           Recorded{"mrs1104_colab_20210722", "sick_mrs1000"}),
                         [](const auto& each) { return std::string(each.param.model); });

}  // namespace
}  // namespace lidard::test
