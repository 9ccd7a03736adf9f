// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Velodynes on bad days: packets that come late or twice beside a loss, clocks that are set, streams that
// begin again, silences whose end the stamps contradict.
#include <gtest/gtest.h>

#include <cmath>

#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "drivers/velodyne/timing.h"
#include "test/support/captures.h"
#include "test/support/collector.h"
#include "test/support/velodyne_wire.h"

namespace lidard {
namespace {

using test::Collector;
using test::ModelMode;
using test::WirePacket;

constexpr std::size_t stale_index = static_cast<std::size_t>(Reject::stale);
constexpr std::size_t duplicate_index = static_cast<std::size_t>(Reject::duplicate);

DriverConfig config_of(const std::string& model) {
  DriverConfig config;
  config.model = find_model(model);
  config.clock = ClockMode::arrival;
  config.keep_origins = true;
  return config;
}

struct Played {
  Collector out;
  Counters counters;
};

Played play(const std::string& model, const std::vector<WirePacket>& packets) {
  const DriverConfig config = config_of(model);
  const auto driver = config.model->make(config);
  Played played;
  for (const WirePacket& packet : packets) test::give(*driver, packet, played.out);
  driver->finish(played.out);
  played.counters = driver->counters();
  return played;
}

/// Where and when all returns are, but for the numbers of their packets.
void expect_same_returns(const Collector& is, const Collector& should, const std::string& what) {
  ASSERT_EQ(is.clouds.size(), should.clouds.size()) << what;
  ASSERT_EQ(is.rows.size(), should.rows.size()) << what;
  for (std::size_t i = 0; i < is.rows.size(); ++i) {
    const auto &a = is.rows[i], &b = should.rows[i];
    ASSERT_EQ(a.stamp_ns, b.stamp_ns) << what << ", row " << i;
    ASSERT_EQ(a.azimuth_deg, b.azimuth_deg) << what << ", row " << i;
    ASSERT_EQ(a.laser, b.laser) << what << ", row " << i;
    ASSERT_EQ(a.x, b.x) << what << ", row " << i;
  }
  for (std::size_t i = 0; i < is.clouds.size(); ++i) {
    EXPECT_EQ(is.clouds[i].stamp, should.clouds[i].stamp) << what;
    EXPECT_EQ(is.clouds[i].end, should.clouds[i].end) << what;
  }
}

std::uint32_t stamp_of(const WirePacket& packet) {
  return ByteView(packet.bytes.data(), packet.bytes.size()).le32(1200);
}
void set_stamp(WirePacket& packet, std::uint32_t us) {
  for (std::size_t i = 0; i < 4; ++i) packet.bytes[1200 + i] = static_cast<std::uint8_t>(us >> (8 * i));
}

// A late packet may come while one is held back because of a hole before it.
TEST(VelodyneOrder, AStalePacketAfterAHoleIsNeitherUsedNorTakenForTheMissingOne) {
  for (const char* model : {"velodyne_vlp16", "velodyne_vlp32c", "velodyne_hdl32e"}) {
    auto packets = test::spin({model, sim::ReturnMode::strongest, ""}, 2.3);
    packets.erase(packets.begin() + 100);
    const Played expected = play(model, packets);
    for (const std::size_t late : {20U, 97U, 98U}) {
      auto with = packets;
      WirePacket again = packets[late];
      again.arrival = packets[100].arrival;
      with.insert(with.begin() + 101, again);
      const Played played = play(model, with);
      EXPECT_EQ(played.counters.rejected[stale_index], 1U) << model << ", " << late;
      EXPECT_EQ(played.counters.reordered, 1U) << model;
      EXPECT_EQ(played.counters.lost_packets, expected.counters.lost_packets) << model;
      expect_same_returns(played.out, expected.out,
                          std::string(model) + " and packet " + std::to_string(late));
    }
  }
}

TEST(VelodyneOrder, AMissingPacketThatComesOnePlaceLateIsPutWhereItBelongs) {
  for (const char* model : {"velodyne_vlp16", "velodyne_vlp32c", "velodyne_hdl64e_s2"}) {
    const auto packets = test::spin({model, sim::ReturnMode::strongest, ""}, 1.6);
    const Played expected = play(model, packets);
    auto swapped = packets;
    std::swap(swapped[60].bytes, swapped[61].bytes);
    std::swap(swapped[90].bytes, swapped[91].bytes);
    const Played played = play(model, swapped);
    EXPECT_EQ(played.counters.reordered, 2U) << model;
    EXPECT_EQ(played.counters.lost_packets, expected.counters.lost_packets) << model;
    EXPECT_EQ(played.counters.rejected_total(), 0U) << model;
    ASSERT_EQ(played.out.rows.size(), expected.out.rows.size()) << model;
    for (std::size_t i = 0; i < played.out.rows.size(); ++i) {
      ASSERT_EQ(played.out.rows[i].azimuth_deg, expected.out.rows[i].azimuth_deg) << model << ", row " << i;
      ASSERT_EQ(played.out.rows[i].laser, expected.out.rows[i].laser) << model << ", row " << i;
    }
  }
}

TEST(VelodyneOrder, APacketThatComesTwiceIsUsedOnceAlsoWhileItIsHeldBack) {
  auto packets = test::spin({"velodyne_vlp16", sim::ReturnMode::strongest, ""}, 1.6);
  packets.erase(packets.begin() + 50);
  const Played expected = play("velodyne_vlp16", packets);
  for (const std::size_t twice : {10U, 50U, 51U}) {
    auto with = packets;
    with.insert(with.begin() + static_cast<std::ptrdiff_t>(twice) + 1, packets[twice]);
    const Played played = play("velodyne_vlp16", with);
    EXPECT_EQ(played.counters.rejected[duplicate_index], 1U) << twice;
    EXPECT_EQ(played.counters.reordered, 0U) << twice;
    expect_same_returns(played.out, expected.out, "twice " + std::to_string(twice));
  }
}

/// The stream of a sensor at one speed, in view of a part of the turn or of all, its stamps moved by so much.
std::vector<WirePacket> moved_stream(const ModelMode& which, bool hides, double turn_factor,
                                     std::int64_t stamp_us, Span arrival) {
  sim::VelodyneOptions options;
  options.turn_deg = which.turn_deg() * turn_factor;
  if (hides) options.fov = sim::AzimuthSector{270, 90};
  auto packets = test::spin(which, 2.4, options);
  for (WirePacket& packet : packets) {
    const std::int64_t hour = 3'600'000'000;
    set_stamp(packet, static_cast<std::uint32_t>((stamp_of(packet) + stamp_us + 10 * hour) % hour));
    packet.arrival = packet.arrival + arrival;
  }
  return packets;
}

/// The newest rows of `played` are those of `alone`, but for a hundredth of a degree and 2 us.
std::size_t differing_rows(const Collector& played, const Collector& alone) {
  const std::size_t skip = played.rows.size() - alone.rows.size();
  std::size_t differ = 0;
  for (std::size_t i = 0; i < alone.rows.size(); ++i) {
    const auto &a = played.rows[skip + i], &b = alone.rows[i];
    differ += std::abs(std::remainder(a.azimuth_deg - b.azimuth_deg, 360)) > 0.001 || a.laser != b.laser ||
                      std::abs(a.stamp_ns - b.stamp_ns) > 2000
                  ? 1
                  : 0;
  }
  return differ;
}

// After its clock was set a sensor is decoded as if it had just been switched on: nothing of the time before
// the jump is left, the speed of its motor above all.
TEST(VelodyneClock, AfterAJumpNothingOfTheTimeBeforeIsLeft) {
  for (const ModelMode& which : {ModelMode{"velodyne_vlp16", sim::ReturnMode::strongest, ""},
                                 ModelMode{"velodyne_vls128", sim::ReturnMode::strongest, ""},
                                 ModelMode{"velodyne_vlp32c", sim::ReturnMode::dual, ""}}) {
    for (const bool hides : {false, true}) {
      const auto before = moved_stream(which, hides, 1, 0, Span(0));
      const Played first = play(which.model, before);
      for (const std::int64_t jump_us : {-700'000'000LL, 700'000'000LL}) {
        const auto after = moved_stream(which, hides, 0.5, jump_us, std::chrono::seconds(1));
        const Played alone = play(which.model, after);
        auto both = before;
        both.insert(both.end(), after.begin(), after.end());
        const Played played = play(which.model, both);
        const std::string what = which.name() + (hides ? " hides, " : ", ") + std::to_string(jump_us);
        EXPECT_EQ(played.counters.clock_steps, 1U) << what;
        EXPECT_EQ(played.counters.rejected_total(), 0U) << what;
        // No frame is made of what came before the jump and what came after it.
        ASSERT_EQ(played.out.rows.size(), first.out.rows.size() + alone.out.rows.size()) << what;
        EXPECT_EQ(played.counters.partial_frames,
                  first.counters.partial_frames + alone.counters.partial_frames)
            << what;
        EXPECT_EQ(differing_rows(played.out, alone.out), 0U) << what;
      }
    }
  }
}

// Stamps count within an hour: a pause of a little less than whole hours looks like a late packet, but for
// its arrival.
TEST(VelodyneClock, APauseOfAboutWholeHoursLosesNothing) {
  for (const ModelMode& which : {ModelMode{"velodyne_vlp16", sim::ReturnMode::strongest, ""},
                                 ModelMode{"velodyne_vlp32c", sim::ReturnMode::dual, ""}}) {
    const auto before = moved_stream(which, false, 1, 0, Span(0));
    const Span lasted = before.back().arrival - before.front().arrival;
    for (const int hours : {1, 2, 6}) {
      for (const double more_s : {-20.0, -0.9, -0.1, -0.001, 0.003, 0.5, 20.0}) {
        const Span away = lasted + std::chrono::hours(hours) + span_from_seconds(more_s);
        const auto after = moved_stream(which, false, 1, away.count() / 1000, away);
        auto both = before;
        both.insert(both.end(), after.begin(), after.end());
        const Counters counters = play(which.model, both).counters;
        const std::string what =
            which.name() + ", " + std::to_string(hours) + " h " + std::to_string(more_s) + " s";
        EXPECT_EQ(counters.packets, both.size()) << what;
        EXPECT_EQ(counters.lost_packets, 0U) << what;
        EXPECT_EQ(counters.rejected_total(), 0U) << what;
        EXPECT_EQ(counters.reordered, 0U) << what;
        EXPECT_EQ(counters.frames, 2 * play(which.model, before).counters.frames) << what;
      }
    }
  }
}

TEST(VelodyneClock, SixHoursWithPacketsAboutEachFullHourLoseNothing) {
  LIDARD_NEED_CAPTURE(path, "velodyne/vlp16_six_hours_of_silence.pcap.gz");
  const Counters counters = test::decode_capture(path, "velodyne_vlp16").counters;
  EXPECT_EQ(counters.packets, 1800U);
  EXPECT_EQ(counters.lost_packets, 0U);
  EXPECT_EQ(counters.rejected_total(), 0U);
  EXPECT_EQ(counters.frames, 42U);
}

// VLP-16 user manual 63-9243 Rev D, 9.3: a block is two firing sequences of 55.296 us.
TEST(FiringSchedule, NeverRunsBackwardsOverASilenceWhateverTheNextStampSays) {
  using namespace velodyne;
  const auto& row = *static_cast<const ModelRow*>(find_model("velodyne_vlp16")->row);
  const Timing& timing = row.timings.front();
  PacketAzimuths azimuths;
  azimuths.groups = 12;
  azimuths.step_deg = 0.4;
  azimuths.hidden_deg[5] = 30;
  azimuths.hidden_total_deg = 30;
  const Span group = std::chrono::nanoseconds(110'592);
  const Span busy = group * 12;
  const double rate = 0.4 / seconds(group);
  const Span silence = span_from_seconds(30 / rate);
  const auto schedule = [&](std::optional<NextPacket> next, double turn_rate) {
    return schedule_of(row, timing, timing.sequence, azimuths, 1, next, turn_rate);
  };
  const auto silence_in = [&](const FiringSchedule& s) { return s.begin[5] - s.begin[4] - group; };
  // The next packet's stamp tells it exactly.
  const Span exact = silence + std::chrono::microseconds(7);
  EXPECT_EQ(silence_in(schedule(NextPacket{busy + exact}, rate)), exact);
  EXPECT_EQ(silence_in(schedule(NextPacket{busy}, rate)), Span(0)) << "nothing is left for a silence";
  // A stamp before the packet could have ended contradicts it; then the motor's speed tells.
  for (const Span step : {busy - Span(1), group, Span(0), -busy}) {
    const FiringSchedule s = schedule(NextPacket{step}, rate);
    EXPECT_NEAR(seconds(silence_in(s)), seconds(silence), 1e-6) << step.count();
    for (std::size_t g = 1; g < 12; ++g) EXPECT_GE(s.begin[g] - s.begin[g - 1], group) << step.count();
    EXPECT_NEAR(seconds(s.end), seconds(busy + silence), 1e-6);
  }
  // More than half a packet longer than the motor allows: packets between them were lost.
  EXPECT_EQ(silence_in(schedule(NextPacket{busy + silence + busy / 2 - Span(10)}, rate)),
            silence + busy / 2 - Span(10));
  EXPECT_NEAR(seconds(silence_in(schedule(NextPacket{busy + silence + busy / 2 + Span(1000)}, rate))),
              seconds(silence), 1e-6);
  // Without either nothing is known of the silence.
  EXPECT_EQ(silence_in(schedule(std::nullopt, 0)), Span(0));
  EXPECT_NEAR(seconds(silence_in(schedule(std::nullopt, rate))), seconds(silence), 1e-6);
}

TEST(FiringSchedule, DividesASilenceAmongItsSectorsByTheirWidth) {
  using namespace velodyne;
  const auto& row = *static_cast<const ModelRow*>(find_model("velodyne_vlp16")->row);
  PacketAzimuths azimuths;
  azimuths.groups = 12;
  azimuths.step_deg = 0.4;
  azimuths.hidden_deg[3] = 10;
  azimuths.hidden_deg[8] = 30;
  azimuths.hidden_total_deg = 40;
  const Span group = std::chrono::nanoseconds(110'592);
  const Span silence = std::chrono::milliseconds(8);
  const auto s = schedule_of(row, row.timings.front(), row.timings.front().sequence, azimuths, 1,
                             NextPacket{group * 12 + silence}, 0);
  EXPECT_EQ(s.begin[0], Span(0));
  for (std::size_t g = 1; g < 12; ++g) {
    const Span quiet = g == 3 ? silence / 4 : g == 8 ? silence * 3 / 4 : Span(0);
    EXPECT_EQ(s.begin[g] - s.begin[g - 1], group + quiet) << g;
  }
  EXPECT_EQ(s.end, group * 12 + silence);
}

}  // namespace
}  // namespace lidard
