// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "daemon/health/pipeline_health.h"
#include "daemon/pipeline/frame_tree.h"
#include "daemon/pipeline/pipeline.h"
#include "test/support/recording_sink.h"

namespace lidard {
namespace {

using ::testing::HasSubstr;

struct ChangedVehicle {
  Config config = parse_config(R"(
sensors:
  left: {topic: left, pose: {xyz: [0, 0, 0]}}
  roof: {topic: roof, pose: {xyz: [0, 0, 0]}}
merged_scans:
  around: {laserscan_topics: [left], angle_min: -1.5, angle_max: 1.5, angle_increment: 0.01, range_max: 20}
virtual_scans:
  levels: {cloud_topic: roof, virtual_laser_scan: [bumper], poses: {bumper: {xyz: [0, 0, 0]}}, range_max: 20}
)",
                               "p");
  NoTransforms none;
  test::RecordingSink sink;
  Pipeline pipeline{config, none, sink};
  std::int64_t frames = 0;

  Stamp next() { return Stamp{1'000'000'000LL + ++frames * 50'000'000}; }
  const PlanarScan& send_scan() {
    PlanarScan scan;
    scan.frame_id = "left";
    scan.reset(100, 1, false);
    scan.set_angles(-1, 0.02F);
    scan.range_max = 30;
    for (std::size_t i = 0; i < scan.beams; ++i) scan.set_hit(i, 5);
    scan.stamp = next();
    pipeline.scan_message("left", scan, scan.stamp);
    return sink.scans["around"].back();
  }
  const PlanarScan& send_cloud() {
    Cloud cloud;
    cloud.frame_id = "roof";
    cloud.rings = 1;
    cloud.points_bytes.resize(sizeof(CloudPoint));
    *cloud.points() = {5, 0, 0.3F, 1, 0, 0};
    cloud.stamp = cloud.end = next();
    pipeline.cloud_message("roof", cloud, cloud.stamp);
    return sink.scans["bumper"].back();
  }
  std::string published() const {
    for (const auto& item : items_of(pipeline, Stamp{2'000'000'000})) {
      if (item.name == "merged around") return item.values.at(0).second;
    }
    return "no such item";
  }
};

TEST(OutputChange, TakesEffectWithTheNextInputAndKeepsCounting) {
  ChangedVehicle vehicle;
  EXPECT_EQ(vehicle.send_scan().beams, 301U);
  OutputScanConfig wanted = vehicle.config.merged_scans[0].output;
  wanted.grid.angle_increment = 0.02;
  wanted.grid.range_max = 4;
  EXPECT_EQ(vehicle.pipeline.set_scan({MakerId::Kind::merged, "around"}, wanted), "");
  const PlanarScan& scan = vehicle.send_scan();
  EXPECT_EQ(scan.beams, 151U);
  EXPECT_EQ(scan.range_max, 4);
  for (const BeamStatus status : scan.statuses)
    EXPECT_EQ(status, BeamStatus::none) << "hits are farther away";
  EXPECT_GT(scan.stamp, vehicle.sink.scans["around"][0].stamp);
  EXPECT_EQ(vehicle.published(), "2");
}

TEST(OutputChange, AppliesToVirtualScans) {
  ChangedVehicle vehicle;
  const auto hits = [](const PlanarScan& scan) {
    return std::count(scan.statuses.begin(), scan.statuses.end(), BeamStatus::hit);
  };
  EXPECT_EQ(hits(vehicle.send_cloud()), 0) << "above the default height";
  OutputScanConfig wanted = vehicle.config.virtual_scans[0].output;
  wanted.max_height = 0.5;
  EXPECT_EQ(vehicle.pipeline.set_scan({MakerId::Kind::virtual_group, "levels"}, wanted), "");
  EXPECT_EQ(hits(vehicle.send_cloud()), 1);
}

TEST(OutputChange, IsRefusedForAGridThatIsWrongOrAnOutputThatIsNot) {
  ChangedVehicle vehicle;
  OutputScanConfig wanted = vehicle.config.merged_scans[0].output;
  EXPECT_THAT(vehicle.pipeline.set_scan({MakerId::Kind::virtual_group, "around"}, wanted),
              HasSubstr("no output named around"));
  wanted.grid.angle_max = -2;
  EXPECT_THAT(vehicle.pipeline.set_scan({MakerId::Kind::merged, "around"}, wanted),
              HasSubstr("expected angle_min < angle_max"));
  EXPECT_EQ(vehicle.send_scan().beams, 301U);
}

}  // namespace
}  // namespace lidard
