// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Sectors and the order of beams of scanners that turn clockwise, from the packets to the published scans.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "daemon/offline/no_transforms.h"
#include "daemon/offline/player.h"
#include "test/sim/servers/scene_file.h"
#include "test/sim/servers/simulate.h"
#include "test/support/captures.h"
#include "test/support/recording_sink.h"

namespace lidard::test {
namespace {

using Scans = std::map<std::string, std::vector<PlanarScan>>;

/// A NAV310 among four cylinders: ahead 2 m, to the left 3 m, behind 4 m, to the right 5 m away.
Scans nav_scans(const std::string& path, const std::string& keys, const std::string& more = "") {
  const Config config =
      parse_config("sensors: {s: {model: sick_nav31x, ip_address: 192.168.0.3, pose: {xyz: [0, 0, 0]}" +
                       keys + "}}\n" + more,
                   "f");
  NoTransforms poses;
  RecordingSink sink;
  Pipeline pipeline(config, poses, sink);
  PlayOptions options;
  options.rate = 0;
  MergedCapture capture({path});
  Player player(options, capture, pipeline);
  player.play([] { return false; });
  return std::move(sink.scans);
}

/// The range at an angle, deg, in whichever turn; -1: there is no such beam.
float range_at(const PlanarScan& scan, double deg) {
  for (std::size_t beam = 0; beam < scan.beams; ++beam) {
    const double off = std::remainder(static_cast<double>(scan.angle(beam)) * deg_per_rad - deg, 360.0);
    if (std::abs(off) <= 0.126) return scan.ranges[beam];
  }
  return -1;
}

std::size_t observed(const PlanarScan& scan) {
  return static_cast<std::size_t>(std::count_if(scan.statuses.begin(), scan.statuses.end(),
                                                [](BeamStatus s) { return s != BeamStatus::invalid; }));
}

constexpr const char* capture = "reports/01-window-over-pi/nav.pcap";

TEST(ScanSector, OfAFullCircleKeepsEveryBeamAndOneAcrossTheSeamBothItsEnds) {
  LIDARD_NEED_CAPTURE(path, capture);
  for (const char* all :
       {", angle_min: 0.0, angle_max: 6.283185307179586", ", angle_min_deg: -180, angle_max_deg: 180"}) {
    const PlanarScan scan = nav_scans(path, all).at("s/scan").back();
    EXPECT_EQ(observed(scan), 1440U) << all;
    EXPECT_NEAR(range_at(scan, -90), 4.8, 0.05);
    EXPECT_NEAR(range_at(scan, 90), 2.8, 0.05);
  }
  for (const char* rear :
       {", angle_min_deg: 90, angle_max_deg: 270", ", angle_min_deg: 90, angle_max_deg: -90"}) {
    const PlanarScan scan = nav_scans(path, rear).at("s/scan").back();
    EXPECT_EQ(observed(scan), 721U) << rear;
    EXPECT_NEAR(range_at(scan, 180), 3.8, 0.05);
    EXPECT_NEAR(range_at(scan, 90), 2.8, 0.05);
    EXPECT_NEAR(range_at(scan, -90), 4.8, 0.05);
    EXPECT_TRUE(std::isnan(range_at(scan, 0)));
  }
  const PlanarScan most = nav_scans(path, ", angle_min: 0.0, angle_max: 4.71").at("s/scan").back();
  EXPECT_EQ(observed(most), 1080U);
}

TEST(ScanOrder, OfAClockwiseScannerIsReversedOnRequestAndMergesAsBefore) {
  LIDARD_NEED_CAPTURE(path, capture);
  const std::string merged = "merged_scans: {m: {laserscan_topics: [s], profile: strict, range_max: 20}}\n";
  const Scans clockwise = nav_scans(path, "", merged),
              turned = nav_scans(path, ", counter_clockwise: true", merged);
  const auto& before = clockwise.at("s/scan");
  const auto& after = turned.at("s/scan");
  ASSERT_EQ(before.size(), after.size());
  EXPECT_LT(before[0].angle_increment, 0);
  EXPECT_GT(after[0].angle_increment, 0);
  EXPECT_GT(after[0].angle_max, after[0].angle_min);
  for (std::size_t i = 0; i < after.size(); ++i) {
    const std::size_t last = before[i].beams - 1;
    for (std::size_t beam = 0; beam <= last; ++beam) {
      ASSERT_NEAR(after[i].angle(beam), before[i].angle(last - beam), 1e-5);
      const float here = after[i].ranges[beam], there = before[i].ranges[last - beam];
      ASSERT_TRUE(here == there || (std::isnan(here) && std::isnan(there)));
      const auto at = [](const PlanarScan& scan, std::size_t b) {
        return seconds(scan.stamp - Stamp{}) +
               static_cast<double>(scan.time_increment) * static_cast<double>(b);
      };
      ASSERT_NEAR(at(after[i], beam), at(before[i], last - beam), 1e-6);
    }
  }
  ASSERT_EQ(clockwise.at("m").size(), turned.at("m").size());
  for (std::size_t i = 0; i < turned.at("m").size(); ++i)
    EXPECT_EQ(clockwise.at("m")[i].statuses, turned.at("m")[i].statuses);
}

}  // namespace
}  // namespace lidard::test
