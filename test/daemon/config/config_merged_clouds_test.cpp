// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/offline/remarks.h"
#include "drivers/registry/registry.h"
#include "test/daemon/config/config_support.h"

namespace lidard {
namespace {

using test::error_of;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const std::string sensors =
    "vehicle: {base_frame: base}\n"
    "sensors:\n"
    "  roof: {model: velodyne_vlp16, ip_address: 10.0.0.1, pose: {xyz: [0, 1, 2]}}\n"
    "  tail: {model: velodyne_vls128, ip_address: 10.0.0.2, pose: {xyz: [0, -1, 2]}}\n"
    "  front: {model: sick_microscan3, ip_address: 10.0.0.3, pose: {xyz: [1, 0, 0.4]}}\n"
    "  camera: {topic: /camera/points, pose: {xyz: [1, 0, 1]}}\n"
    "merged_clouds:\n";

std::string error_with(const std::string& entry) { return error_of(sensors + "  " + entry + "\n"); }
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

TEST(MergedCloudConfigs, MistakesNameTheirPlaceAndTheRemedy) {
  const std::string expected = "; expected names of sensors: roof tail front camera";
  EXPECT_EQ(error_with("around: {}"), "f:8:3: merged_clouds.around has no sources" + expected);
  EXPECT_EQ(error_with("around: {sources: []}"),
            "f:8:21: merged_clouds.around.sources names nothing" + expected);
  EXPECT_EQ(error_with("around: {sources: [roof, tial]}"),
            "f:8:28: merged_clouds.around.sources[1] names \"tial\", which is no sensor and no topic of one; "
            "expected tail");
  EXPECT_EQ(error_with("around: {sources: [roof, roof/points]}"),
            "f:8:28: merged_clouds.around.sources[1] names roof again; expected every source once");
  EXPECT_EQ(error_with("roof: {sources: [roof, tail]}"),
            "f:8:3: merged_clouds.roof is the name of a sensor too; expected a name of its own");
  EXPECT_EQ(error_with("around: {sources: [roof], destination_topic: tail}"),
            "f:8:48: merged_clouds.around.destination_topic is the name of a sensor too; expected a topic of "
            "its own");
  EXPECT_EQ(error_with("around: {sources: [roof], destination_topic: roof/points}"),
            "f:8:48: merged_clouds.around.destination_topic would publish on roof/points, the topic of "
            "sensors.roof; "
            "expected a topic of its own");
  EXPECT_EQ(error_with("around: {sources: [roof], trigger: tail}"),
            "f:8:38: merged_clouds.around.trigger is \"tail\", which is no source of it; expected one of "
            "sources: roof");
  EXPECT_THAT(error_with("around: {sources: [roof], profile: strict}"),
              HasSubstr("unknown key merged_clouds.around.profile"));
}

TEST(MergedCloudConfigs, OneMergedCloudIsNoSourceOfAnother) {
  EXPECT_THAT(error_with("a: {sources: [roof]}\n  b: {sources: [a, tail]}"), HasSubstr("merged cloud"));
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

TEST(MergedCloudConfigs, GiveNoScansForMergedScans) {
  EXPECT_EQ(error_with("around: {sources: [roof]}\nmerged_scans: {m: {laserscan_topics: [around]}}"),
            "f:9:39: merged_scans.m.laserscan_topics[0] names around, a merged cloud, which gives no scans; "
            "expected "
            "names of sensors that give scans: front, camera");
}

TEST(MergedCloudConfigs, ASourceOfAnotherDriverIsTakenForACloud) {
  EXPECT_THAT(
      error_with("around: {sources: [roof, camera]}\nmerged_scans: {m: {laserscan_topics: [camera]}}"),
      HasSubstr("names camera, which merged_clouds.around takes for a cloud"));
}

}  // namespace
}  // namespace lidard
