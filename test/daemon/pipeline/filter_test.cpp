// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// `filter:` of a sensor: of its own topics alone, counted, and said where it does not do what was meant.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "daemon/health/pipeline_health.h"
#include "daemon/offline/no_transforms.h"
#include "daemon/pipeline/pipeline.h"
#include "test/sim/servers/velodyne_stream.h"
#include "test/support/recording_sink.h"
#include "test/support/says.h"

namespace lidard {
namespace {

using ::testing::HasSubstr;

const Endpoint sender{IpAddress::v4(192, 168, 1, 201), 2368};

/// What comes of two revolutions of a VLP-16 that also feeds a virtual scan.
test::RecordingSink play(const std::string& keys) {
  static const std::vector<sim::SimulatedPacket> packets = [] {
    sim::VelodyneSetup setup;
    setup.model = "velodyne_vlp16";
    setup.mode = "dual";
    setup.divergence_mrad = 3;
    setup.duration = std::chrono::milliseconds(2500);
    return simulate_velodyne(setup);
  }();
  const Config config = parse_config(
      "sensors: {roof: {model: velodyne_vlp16, pose: {xyz: [0, 0, 2]}, scan_ring: auto" + keys +
          "}}\nvirtual_scans: {low: {cloud_topic: roof, base_frame: base_link, virtual_laser_scan: [v], "
          "poses: {v: {xyz: [0, 0, 0.5]}}}}",
      "f");
  NoTransforms poses;
  test::RecordingSink sink;
  Pipeline pipeline(config, poses, sink);
  const HealthReporter reporter(pipeline, sink);
  Stamp now = packets.front().arrival;
  for (const auto& packet : packets) {
    pipeline.packet({packet.view(), packet.arrival, sender, {{}, packet.port}});
    for (; now <= packet.arrival; now = now + std::chrono::milliseconds(100)) pipeline.tick(now);
  }
  pipeline.finish(packets.back().arrival);
  return sink;
}

std::vector<CloudPoint> points_of(const Cloud& cloud) {
  return {cloud.points(), cloud.points() + cloud.size()};
}

TEST(SensorFilter, LeavesWhatVirtualScansSeeAsItIs) {
  const test::RecordingSink all = play("");
  const test::RecordingSink some =
      play(", filter: {box: [[1, -900, -900], [900, 900, 900]], voxel_size: 0.2}");
  ASSERT_GT(all.scans.at("v").size(), 5U);
  ASSERT_EQ(some.scans.at("v").size(), all.scans.at("v").size());
  for (std::size_t i = 0; i < all.scans.at("v").size(); ++i) {
    EXPECT_EQ(some.scans.at("v")[i].statuses, all.scans.at("v")[i].statuses);
    EXPECT_EQ(some.scans.at("v")[i].stamp, all.scans.at("v")[i].stamp);
  }
  std::size_t kept = 0;
  for (const Cloud& cloud : some.clouds.at("roof/points")) {
    kept += cloud.size();
    for (const CloudPoint& p : points_of(cloud)) ASSERT_GE(p.x, 1);
  }
  std::size_t came = 0;
  for (const Cloud& cloud : all.clouds.at("roof/points")) came += cloud.size();
  EXPECT_LT(kept, came / 2);
  EXPECT_GT(kept, 1000U);
  // The ring that is a scan is one of the sensor's own topics.
  for (const PlanarScan& scan : some.scans.at("roof/scan")) {
    for (std::size_t b = 0; b < scan.beams; ++b) {
      if (scan.statuses[b] == BeamStatus::hit) {
        ASSERT_GE(scan.ranges[b] * std::cos(scan.angle(b)), 0.999);
      }
    }
  }
  EXPECT_THAT(test::value_of(some.item("sensor roof"), "Filter"), HasSubstr("by box"));
  EXPECT_EQ(test::value_of(all.item("sensor roof"), "Filter"), "no such key");
}

TEST(SensorFilter, OutliersAreReturnsWithTooFewOthersAroundThem) {
  const test::RecordingSink all = play(", filter: {voxel_size: 0.4}");
  const test::RecordingSink some =
      play(", filter: {voxel_size: 0.4, outlier_radius: 0.5, outlier_neighbours: 3}");
  const auto before = points_of(all.clouds.at("roof/points").at(1));
  const auto after = points_of(some.clouds.at("roof/points").at(1));
  std::vector<CloudPoint> expected;
  for (const CloudPoint& p : before) {
    int near = -1;  // itself
    for (const CloudPoint& q : before) near += std::hypot(p.x - q.x, p.y - q.y, p.z - q.z) <= 0.5F;
    if (near >= 3) expected.push_back(p);
  }
  ASSERT_LT(expected.size(), before.size());
  ASSERT_GT(expected.size(), before.size() / 10);
  ASSERT_EQ(after.size(), expected.size());
  for (std::size_t i = 0; i < after.size(); ++i) {
    ASSERT_EQ(after[i].x, expected[i].x);
    ASSERT_EQ(after[i].ring, expected[i].ring);
    ASSERT_EQ(after[i].time, expected[i].time);
  }
}

TEST(SensorFilter, AnOrganisedCloudKeepsItsPlaces) {
  const test::RecordingSink all = play(", organize_cloud: rings");
  const test::RecordingSink some =
      play(", organize_cloud: rings, filter: {cut_out: [[-900, 0, -900], [900, 900, 900]]}");
  const Cloud& before = all.clouds.at("roof/points").at(1);
  const Cloud& after = some.clouds.at("roof/points").at(1);
  ASSERT_EQ(after.size(), before.size());
  std::size_t removed = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    const CloudPoint p = before.points()[i], q = after.points()[i];
    ASSERT_EQ(q.ring, p.ring);
    if (std::isfinite(q.x)) {
      ASSERT_EQ(q.x, p.x);
      ASSERT_LT(q.y, 0);
    } else {
      removed += std::isfinite(p.x);
    }
  }
  EXPECT_GT(removed, 1000U);
}

TEST(SensorFilter, SaysThatNothingIsLeft) {
  const test::RecordingSink none = play(", filter: {box: [[900, -900, -9], [901, 900, 9]]}");
  EXPECT_EQ(none.item("sensor roof").health, Health::warn);
  EXPECT_THAT(none.item("sensor roof").message, test::Says(says::filter_removes_all));
  EXPECT_THAT(none.item("sensor roof").message, HasSubstr("frames on roof/points"));
  // A ring's scan lies at 0; of the cloud few returns do.
  const test::RecordingSink level = play(", filter: {cut_out: [[-900, -900, -0.01], [900, 900, 0.01]]}");
  EXPECT_GT(level.clouds.at("roof/points").back().size(), 1000U);
  EXPECT_THAT(level.item("sensor roof").message, HasSubstr("frames on roof/scan"));
}

}  // namespace
}  // namespace lidard
