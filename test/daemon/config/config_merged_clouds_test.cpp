// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/offline/remarks.h"
#include "drivers/registry/registry.h"
#include "test/daemon/config/config_support.h"

namespace lidard {
namespace {

using ::testing::ElementsAre;

const std::string sensors =
    "vehicle: {base_frame: base}\n"
    "sensors:\n"
    "  roof: {model: velodyne_vlp16, ip_address: 10.0.0.1, pose: {xyz: [0, 1, 2]}}\n"
    "  tail: {model: velodyne_vls128, ip_address: 10.0.0.2, pose: {xyz: [0, -1, 2]}}\n"
    "  front: {model: sick_microscan3, ip_address: 10.0.0.3, pose: {xyz: [1, 0, 0.4]}}\n"
    "  camera: {topic: /camera/points, pose: {xyz: [1, 0, 1]}}\n"
    "merged_clouds:\n";

Config config_with(const std::string& rest) { return parse_config(sensors + "  " + rest + "\n", "f"); }

TEST(MergedCloudConfigs, NameSensorsOfAllKindsByNameOrTopic) {
  const Config config = config_with("around: {sources: [/roof/points, tail, front/scan, /camera/points]}");
  const MergedCloudConfig& merged = config.merged_clouds.at(0);
  EXPECT_THAT(merged.sources, ElementsAre("roof", "tail", "front", "camera"));
  EXPECT_EQ(merged.destination_frame, "base");
  EXPECT_EQ(merged.destination_topic, "around");
  EXPECT_FALSE(merged.organized);
  EXPECT_EQ(merged.schedule.policy, Policy::complete);
  EXPECT_EQ(output_topics(config).back().kind, TopicKind::merged_cloud);
  EXPECT_EQ(output_topics(config).back().name, "around");
  EXPECT_TRUE(remarks_on(config).empty()) << "the camera is used";
}

TEST(MergedCloudConfigs, AreSourcesOfVirtualScansByNameOrTopic) {
  for (const char* name : {"around", "/both"}) {
    const Config config = config_with(
        "around: {sources: [roof, tail, front], destination_topic: /both}\n"
        "virtual_scans: {v: {cloud_topic: " +
        std::string(name) + ", virtual_laser_scan: a, profile: strict}}");
    const VirtualScanConfig& scan = config.virtual_scans.at(0);
    EXPECT_EQ(scan.cloud_topic, "/both");
    EXPECT_THAT(config.lidars_of(scan), ElementsAre("roof", "tail", "front"));
    EXPECT_EQ(scan.output.grid.range_max, find_model("velodyne_vls128")->range_max)
        << "of the farthest-sighted one";
    EXPECT_EQ(scan.no_return_free_range, find_model("velodyne_vlp16")->range_max)
        << "of the shortest-sighted lidar";
    EXPECT_TRUE(config.find_sensor("roof")->driver.keep_too_near &&
                config.find_sensor("tail")->driver.keep_too_near);
    EXPECT_EQ(to_yaml(parse_config(to_yaml(config), "again")), to_yaml(config));
  }
}

}  // namespace
}  // namespace lidard
