// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// The first read of a connection holds several scans that waited for it, as of a host that stood, or of a
// recording that begins there.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "test/drivers/hokuyo/scip_bench.h"
#include "test/drivers/sick/compact/segment_bench.h"
#include "test/sim/devices/uam_device.h"

namespace lidard::test {
namespace {

using namespace std::chrono_literals;
using Reads = std::vector<std::pair<Stamp, std::string>>;  // arrival and bytes

class StampList final : public FrameReceiver {
 public:
  void scan(PlanarScan& scan) override { stamps.push_back(scan.stamp); }
  void cloud(Cloud& cloud) override { stamps.push_back(cloud.stamp); }
  std::vector<Stamp> stamps;
};

/// Stamps where the first `together` reads come as one, with the last of them.
std::vector<Stamp> stamps_of(const char* model, const Reads& reads, std::size_t together) {
  DriverConfig config;
  config.model = find_model(model);
  config.frame_id = "laser";
  const auto driver = config.model->make(config);
  StampList out;
  std::string first;
  for (std::size_t i = 0; i < reads.size(); ++i) {
    if (i < together) first += reads[i].second;
    if (i + 1 < together) continue;
    Packet packet;
    packet.transport = Transport::tcp;
    packet.payload = ByteView(i < together ? first : reads[i].second);
    packet.stream_start = i + 1 == std::max<std::size_t>(together, 1);
    packet.arrival = reads[i].first;
    driver->receive(packet, out);
  }
  EXPECT_EQ(driver->counters().clock_steps, 0U) << model;
  EXPECT_EQ(driver->counters().rejected_total(), 0U) << model;
  return out.stamps;
}

/// `tolerance`: a counter of whole ms hides a part of one at both ends of an interval, until turns enough
/// have shown it.
void expect_intervals(const char* model, const Reads& reads, std::size_t scans_in, double tolerance) {
  const std::vector<Stamp> alone = stamps_of(model, reads, 1);
  for (const std::size_t scans : {2, 5, 12}) {
    const std::vector<Stamp> together = stamps_of(model, reads, scans * scans_in);
    ASSERT_EQ(together.size(), alone.size()) << model;
    for (std::size_t i = 0; i < alone.size(); ++i)
      EXPECT_NEAR(seconds(together[i] - alone[i]), 0, tolerance)
          << model << ", " << scans << " in a read, scan " << i;
  }
}

Reads scans_of(TcpBench& bench) {
  bench.recording = true;
  bench.run(3s);
  Reads scans;
  for (const auto& read : bench.recorded) {
    if (read.second.size() > 1000) scans.push_back(read);
  }
  return scans;
}

TEST(FirstRead, ScansOfAScipSensorKeepTheDevicesIntervals) {
  for (const bool percent : {false, true}) {
    for (const char* model : {"hokuyo_ust_10lx", "hokuyo_utm_30lx_ew"}) {
      sim::ScipDeviceOptions options;
      options.motor_ppm = 2000;
      options.knows_percent = percent;
      if (percent) options.firmware = "4.1.0";
      ScipBench bench(options, {}, model);
      const bool in_us = percent && std::string(model) == "hokuyo_ust_10lx";
      expect_intervals(model, scans_of(bench), 1, in_us ? 1e-4 : 1.5e-3);
    }
  }
}

TEST(FirstRead, ScansOfAUamKeepTheDevicesIntervals) {
  TcpBench bench("hokuyo_uam_05lp");
  sim::UamDevice sensor(
      {},
      [](Stamp, std::size_t beams) {
        return std::vector<sim::UamBeam>(beams, {1500, 100});
      },
      scip_epoch - 100s);
  bench.device = &sensor;
  expect_intervals("hokuyo_uam_05lp", scans_of(bench), 1, 1.5e-3);
}

TEST(FirstRead, SegmentsOfCompactOverTcpKeepTheDevicesIntervals) {
  const SegmentBench bench("sick_lrs4000");
  Reads reads;
  for (std::uint64_t f = 0; f < 40; ++f) {
    for (int i = 0; i < SegmentBench::segments; ++i) {
      const auto telegram = bench.encode(bench.segment(f, i));
      reads.emplace_back(bench.arrival(f, i), std::string(telegram.begin(), telegram.end()));
    }
  }
  expect_intervals("sick_lrs4000", reads, SegmentBench::segments, 1e-4);
}

}  // namespace
}  // namespace lidard::test
