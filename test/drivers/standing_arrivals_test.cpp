// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Captures whose records have no arrival times: all of one time, none, whole seconds, or counted up (as
// text2pcap does). The same capture with its arrival times is the outside truth of the intervals.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "drivers/capture/pcap_source.h"
#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "test/support/captures.h"
#include "test/support/collector.h"

namespace lidard::test {
namespace {

using testing::HasSubstr;
using testing::Not;

using Retime = std::function<Stamp(Stamp arrival, std::size_t packet)>;

constexpr std::int64_t second = 1'000'000'000;

struct Played {
  std::vector<Stamp> stamps;
  DeviceInfo info;
  Counters counters;
};

class StampList final : public FrameReceiver {
 public:
  explicit StampList(std::vector<Stamp>& stamps) : stamps_(stamps) {}
  void scan(PlanarScan& scan) override { stamps_.push_back(scan.stamp); }
  void cloud(Cloud& cloud) override { stamps_.push_back(cloud.stamp); }

 private:
  std::vector<Stamp>& stamps_;
};

Played play(const std::string& path, const std::string& model, std::size_t most, const Retime& retime,
            ClockMode mode = ClockMode::smooth) {
  DriverConfig config;
  config.model = find_model(model);
  config.frame_id = "laser";
  config.clock = mode;
  const auto driver = config.model->make(config);
  Played played;
  StampList out(played.stamps);
  PcapSource source(path);
  ConnectionPicker connection;
  std::size_t number = 0;
  for (Packet packet; number < most && source.next(packet); ++number) {
    // Some recorded devices send to ports of their owner's choice.
    if (packet.transport != config.model->transport) continue;
    if (packet.transport == Transport::tcp && !is_for(*config.model, packet)) continue;
    packet.arrival = retime(packet.arrival, number);
    if (packet.transport == Transport::udp || connection.pick(packet)) driver->receive(packet, out);
  }
  driver->finish(out);
  played.info = info_of(*driver);
  played.counters = driver->counters();
  return played;
}

struct Recorded {
  const char *file, *model;
  std::size_t most;  ///< packets
  double tolerance_s;
};
/// The tolerance is that of the original's stamps: its clocks are not known before some seconds.
const Recorded real_captures[] = {{"velodyne/vlp16_strongest_1000.pcap", "velodyne_vlp16", 460, 1e-3},
                                  {"velodyne/hdl32e_gprmc_876.pcap", "velodyne_hdl32e", 900, 1e-3},
                                  {"velodyne/vls128_strongest_2193.pcap", "velodyne_vls128", 2193, 1e-3},
                                  {"sick/lms111_colab_20210302.pcap", "sick_lms1xx", 100000, 2e-3},
                                  {"sick/tim781s_colab_20210125.pcap", "sick_tim7xxs", 100000, 2e-3},
                                  {"sick/microscan3_398.pcap", "sick_microscan3", 400, 20e-3},
                                  {"sick/picoscan150_compact_frag.pcap", "sick_picoscan150", 500, 2e-3},
                                  {"sick/mrs1104_colab_20210722.pcap", "sick_mrs1000", 100000, 3e-3},
                                  {"sick/multiscan_compact_frag.pcap", "sick_multiscan136", 100000, 2e-3}};
const Recorded simulated_captures[] = {{"pcaps/hokuyo_ust_10lx.pcap", "hokuyo_ust_10lx", 100000, 2e-3},
                                       {"pcaps/hokuyo_utm_30lx_ew.pcap", "hokuyo_utm_30lx_ew", 100000, 2e-3},
                                       {"pcaps/hokuyo_ust_10lx_us.pcap", "hokuyo_ust_10lx", 100000, 2e-3},
                                       {"pcaps/hokuyo_uam_05lp.pcap", "hokuyo_uam_05lp", 100000, 2e-3},
                                       {"pcaps/sick_lms111.pcap", "sick_lms1xx", 100000, 1e-3}};

/// Arrivals that say nothing, in the ways that are known.
std::vector<std::pair<const char*, Retime>> empty_times() {
  return {{"one time", [](Stamp, std::size_t) { return Stamp{1'600'000'000 * second}; }},
          {"none", [](Stamp, std::size_t) { return Stamp{second}; }},
          {"counted up",
           [](Stamp, std::size_t n) { return Stamp{second + static_cast<std::int64_t>(n) * 1000}; }},
          {"whole seconds", [](Stamp a, std::size_t) { return Stamp{a.ns / second * second}; }},
          {"whole seconds, from their end on",
           [](Stamp a, std::size_t) { return Stamp{(a.ns + 987'654'321) / second * second}; }},
          {"whole minutes", [](Stamp a, std::size_t) { return Stamp{a.ns / (60 * second) * 60 * second}; }}};
}

Stamp as_recorded(Stamp arrival, std::size_t) { return arrival; }

void expect_equal_intervals(const Played& truth, const Played& flat, double tolerance_s,
                            const std::string& what) {
  ASSERT_EQ(flat.stamps.size(), truth.stamps.size()) << what;
  ASSERT_GE(truth.stamps.size(), 3U) << what;
  double worst = 0;
  for (std::size_t i = 1; i < truth.stamps.size(); ++i) {
    const double interval = seconds(flat.stamps[i] - flat.stamps[i - 1]);
    // The microScan3's scan numbers went on while it was off; its arrivals show for how long.
    if (seconds(truth.stamps[i] - truth.stamps[i - 1]) > 1) continue;
    worst = std::max(worst, std::abs(interval - seconds(truth.stamps[i] - truth.stamps[i - 1])));
    EXPECT_GT(interval, 0) << what << " frame " << i;
  }
  EXPECT_LT(worst, tolerance_s) << what;
}

void expect_device_intervals(const std::string& path, const Recorded& recorded) {
  const Played truth = play(path, recorded.model, recorded.most, as_recorded);
  ASSERT_FALSE(truth.stamps.empty()) << path;
  EXPECT_THAT(truth.info.warnings, Not(testing::Contains(HasSubstr("arrival")))) << path;
  for (const auto& [name, retime] : empty_times()) {
    const Played flat = play(path, recorded.model, recorded.most, retime);
    expect_equal_intervals(truth, flat, recorded.tolerance_s, path + ", " + name);
    if (seconds(truth.stamps.back() - truth.stamps.front()) < 0.4) continue;
    EXPECT_THAT(flat.info.warnings, testing::Contains(HasSubstr("no arrival times"))) << path << ", " << name;
  }
}

TEST(StandingArrivals, StampsOfRealCapturesFollowTheDevicesClocks) {
  LIDARD_NEED_CAPTURE(first, real_captures[0].file);
  for (const Recorded& recorded : real_captures)
    expect_device_intervals(shared_capture(recorded.file), recorded);
}

TEST(StandingArrivals, StampsOfSimulatedCapturesFollowTheDevicesClocks) {
  for (const Recorded& recorded : simulated_captures)
    expect_device_intervals(project_file(recorded.file), recorded);
}

/// Bursts are usual: of a network card, of TCP after a loss, of a host that stood, at the begin of a stream.
TEST(StandingArrivals, BurstsAreArrivals) {
  const auto bursts_of = [](std::size_t size) {
    return [size](const std::vector<Stamp>& all, std::size_t n) {
      return all[std::min(n / size * size + size - 1, all.size() - 1)];
    };
  };
  const auto standing_until = [](std::size_t first, std::size_t last) {
    return [first, last](const std::vector<Stamp>& all, std::size_t n) {
      return all[n >= first && n < last ? std::min(last, all.size() - 1) : n];
    };
  };
  const auto check = [](const std::string& path, const Recorded& recorded, auto burst, double tolerance_s) {
    std::vector<Stamp> all;
    const auto note = [&all](Stamp arrival, std::size_t n) { return all.resize(n + 1, arrival), arrival; };
    const Played truth = play(path, recorded.model, recorded.most, note);
    const Played late =
        play(path, recorded.model, recorded.most, [&](Stamp, std::size_t n) { return burst(all, n); });
    EXPECT_THAT(late.info.warnings, Not(testing::Contains(HasSubstr("arrival")))) << path;
    ASSERT_EQ(late.stamps.size(), truth.stamps.size());
    // The last tenth: a burst at the begin leaves its own frames in doubt.
    for (std::size_t i = truth.stamps.size() * 9 / 10; i < truth.stamps.size(); ++i)
      EXPECT_NEAR(seconds(late.stamps[i] - truth.stamps[i]), 0, tolerance_s) << path << ", frame " << i;
  };
  for (const Recorded& recorded : simulated_captures) {
    const std::string path = project_file(recorded.file);
    check(path, recorded, bursts_of(4), 0.15);
    check(path, recorded, standing_until(0, 6), 5e-3);
  }
  LIDARD_NEED_CAPTURE(vlp16, real_captures[0].file);
  check(vlp16, real_captures[0], bursts_of(8), 12e-3);
  check(vlp16, real_captures[0], standing_until(0, 150), 3e-3);
  check(vlp16, real_captures[0], standing_until(150, 300), 3e-3);
  const std::string lms = shared_capture(real_captures[3].file);
  check(lms, real_captures[3], standing_until(0, 40), 3e-3);
  check(lms, real_captures[3], standing_until(60, 100), 3e-3);
}

TEST(StandingArrivals, APartOfACaptureMayLackThem) {
  LIDARD_NEED_CAPTURE(path, "velodyne/vlp16_strongest_1000.pcap");
  LIDARD_NEED_CAPTURE(tim, "sick/tim781s_colab_20210125.pcap");
  for (const bool first : {true, false}) {
    // 9.2 s; a part of them lacks its times.
    std::optional<Stamp> begin;
    const auto half = [&](Stamp arrival, std::size_t) {
      if (!begin) begin = arrival;
      const bool lacks = (arrival - *begin < std::chrono::milliseconds(6000)) == first;
      return lacks ? *begin + std::chrono::milliseconds(first ? 0 : 6000) : arrival;
    };
    const Played played = play(tim, "sick_tim7xxs", 100000, half);
    EXPECT_THAT(played.info.warnings, testing::Contains(HasSubstr("no arrival times"))) << first;
    EXPECT_EQ(first,
              testing::Matches(testing::Contains(HasSubstr("a part of the capture")))(played.info.warnings));
    std::size_t uneven = 0;
    for (std::size_t i = 1; i < played.stamps.size(); ++i)
      uneven += std::abs(seconds(played.stamps[i] - played.stamps[i - 1]) - 1.0 / 15) > 3e-3 ? 1U : 0U;
    EXPECT_LE(uneven, 1U) << "where the times begin or end";
  }
}

/// Frames and their lengths.
std::vector<double> lengths(const std::string& path, const std::string& model, bool flat, DeviceInfo& info) {
  DriverConfig config;
  config.model = find_model(model);
  config.frame_id = "laser";
  config.keep_partial = true;
  const auto driver = config.model->make(config);
  Collector out;
  // Again and again, since it is short.
  PcapSource source(path);
  for (int round = 0; round < 6; ++round, source.rewind()) {
    for (Packet packet; source.next(packet);) {
      packet.arrival = flat ? Stamp{second} : packet.arrival + round * std::chrono::milliseconds(100);
      driver->receive(packet, out);
    }
  }
  driver->finish(out);
  info = info_of(*driver);
  std::vector<double> all;
  for (const Cloud& cloud : out.clouds) all.push_back(seconds(cloud.end - cloud.stamp));
  return all;
}

TEST(StandingArrivals, ASensorWithoutAClockIsStampedByItsNominalPeriod) {
  LIDARD_NEED_CAPTURE(path, "velodyne/hdl64e_s1_atwall_306.pcap");
  DeviceInfo info;
  const auto truth = lengths(path, "velodyne_hdl64e_s1", false, info);
  const auto flat = lengths(path, "velodyne_hdl64e_s1", true, info);
  EXPECT_THAT(info.warnings, testing::Contains(HasSubstr("sends no time either")));
  ASSERT_EQ(flat.size(), truth.size());
  double whole = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (truth[i] < 5e-3) continue;  // the head seems to stand from one round to the next
    EXPECT_NEAR(flat[i], truth[i], 0.02 * truth[i] + 2e-4) << i;
    whole += truth[i];
  }
  EXPECT_GT(whole, 0.05);
}

/// A CoLa A telegram whose times since start and of transmission are 0.
std::string without_times(std::string_view bytes) {
  std::string text;
  std::size_t field = 0;
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t end = std::min(bytes.find(' ', at), bytes.size());
    const bool is_time = field == 9 || field == 10;
    text += is_time ? "0" : std::string(bytes.substr(at, end - at));
    if (end < bytes.size()) text += ' ';
    at = end + 1;
    ++field;
  }
  return text;
}

TEST(StandingArrivals, ASensorThatSendsZerosAsItsTimeIsPlacedByItsArrivalsOrItsPeriod) {
  for (const bool flat : {false, true}) {
    DriverConfig config;
    config.model = find_model("sick_tim5xx");
    config.frame_id = "laser";
    const auto driver = config.model->make(config);
    std::vector<Stamp> stamps, arrivals;
    StampList out(stamps);
    PcapSource source(project_file("pcaps/sick_tim571_text.pcap"));
    for (Packet packet; source.next(packet);) {
      if (!is_for(*config.model, packet)) continue;
      const std::string text = packet.payload.text().find("sSN LMDscandata ") != std::string_view::npos
                                   ? without_times(packet.payload.text())
                                   : std::string(packet.payload.text());
      packet.payload = ByteView(text);
      if (flat) packet.arrival = Stamp{second};
      driver->receive(packet, out);
    }
    ASSERT_GT(stamps.size(), 5U);
    for (std::size_t i = 1; i < stamps.size(); ++i)
      EXPECT_NEAR(seconds(stamps[i] - stamps[i - 1]), 1.0 / 15, 2e-3) << flat << ", scan " << i;
    EXPECT_FALSE(driver->sends_time());
    EXPECT_EQ(info_of(*driver).warnings.empty(), !flat);
  }
}

}  // namespace
}  // namespace lidard::test
