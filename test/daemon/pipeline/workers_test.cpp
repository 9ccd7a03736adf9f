// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/workers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace lidard {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

const std::string mixed = R"(
vehicle: {odometry_topic: /odom}
sensors:
  left: {model: sick_microscan3, ip_address: 10.0.0.1, ip_port: 6060, pose: {xyz: [1, 0, 0]}}
  low_port: {model: sick_microscan3, ip_address: 10.0.0.2, ip_port: 2368, pose: {xyz: [2, 0, 0]}}
  roof: {model: velodyne_vlp16, ip_address: 10.0.0.3, ip_port: 2368, scan_ring: 7, pose: {xyz: [0, 0, 2]}}
  camera: {topic: /camera/points, pose: {xyz: [3, 0, 1]}}
  other: {topic: /other/scan, pose: {xyz: [4, 0, 1]}}
merged_scans:
  around: {laserscan_topics: [left, low_port, roof, bumper, other], range_max: 20, profile: flatten}
virtual_scans:
  levels: {cloud_topic: camera, virtual_laser_scan: [bumper], poses: {bumper: {xyz: [0, 0, 0.4]}}, range_max: 20}
)";

Config divided(const std::string& text) {
  Config config = parse_config(text, "f");
  assign_workers(config);
  return config;
}

std::vector<std::string> sensors_of(const Config& config, Worker worker) {
  std::vector<std::string> names;
  for (const SensorConfig& sensor : config.sensors) {
    if (sensor.worker == worker) names.push_back(sensor.name);
  }
  return names;
}

std::vector<std::string> topics_of(const Config& config, Worker worker) {
  std::vector<std::string> names;
  for (const OutputTopic& topic : output_topics(config)) {
    if (topic.worker == worker && topic.promised) names.push_back(topic.name);
  }
  return names;
}

TEST(Workers, PlanarScannersAndMergedScansStayWithTheSensorThreadCloudsAndVirtualScansDoNot) {
  const Config config = divided(mixed);
  EXPECT_THAT(sensors_of(config, Worker::clouds), ElementsAre("low_port", "roof", "camera"))
      << "low_port shares a UDP port";
  EXPECT_THAT(sensors_of(config, Worker::sensors), ElementsAre("left", "other"));
  EXPECT_THAT(topics_of(config, Worker::clouds),
              ElementsAre("low_port/scan", "roof/points", "roof/scan", "bumper"));
  EXPECT_THAT(topics_of(config, Worker::sensors), ElementsAre("left/scan", "around"));
  for (const char* source : {"low_port", "roof", "bumper"})
    EXPECT_EQ(config.worker_of(source), Worker::clouds) << source;
  for (const char* source : {"left", "other"}) EXPECT_EQ(config.worker_of(source), Worker::sensors) << source;
}

TEST(Workers, APlanarScannerOfAMergedCloudGoesWithIt) {
  const Config config = divided(mixed + "merged_clouds:\n  all: {sources: [roof, left, camera]}\n");
  EXPECT_THAT(sensors_of(config, Worker::clouds), ElementsAre("left", "low_port", "roof", "camera"));
  EXPECT_EQ(config.worker_of("left"), Worker::clouds);
  EXPECT_THAT(topics_of(config, Worker::sensors), ElementsAre("around"));
  Config only_clouds = config;
  only_clouds.virtual_scans.clear();
  only_clouds.merged_scans.clear();
  EXPECT_TRUE(vehicle_for(only_clouds, Worker::clouds).has_motion());
}

TEST(Workers, WithoutADivisionTheSensorThreadDoesEverything) {
  const Config config = parse_config(mixed, "f");
  EXPECT_THAT(sensors_of(config, Worker::clouds), IsEmpty());
  EXPECT_THAT(topics_of(config, Worker::clouds), IsEmpty());
  EXPECT_EQ(config.worker_of("bumper"), Worker::sensors);
  EXPECT_TRUE(vehicle_for(config, Worker::sensors).has_motion());
  EXPECT_FALSE(vehicle_for(config, Worker::clouds).has_motion());
}

TEST(Workers, TheVehiclesMotionIsFollowedWhereScansAreMade) {
  Config all = divided(mixed);
  EXPECT_TRUE(vehicle_for(all, Worker::sensors).has_motion());
  EXPECT_TRUE(vehicle_for(all, Worker::clouds).has_motion());
  Config only_virtual = all, only_merged = all;
  only_virtual.merged_scans.clear();
  only_merged.virtual_scans.clear();
  EXPECT_FALSE(vehicle_for(only_virtual, Worker::sensors).has_motion());
  EXPECT_TRUE(vehicle_for(only_virtual, Worker::clouds).has_motion());
  EXPECT_TRUE(vehicle_for(only_merged, Worker::sensors).has_motion());
  EXPECT_FALSE(vehicle_for(only_merged, Worker::clouds).has_motion());
  all.merged_scans.clear();
  all.virtual_scans.clear();
  EXPECT_TRUE(vehicle_for(all, Worker::sensors).has_motion()) << "one worker reports the motion's state";
  EXPECT_FALSE(vehicle_for(all, Worker::clouds).has_motion());
}

TEST(Workers, TheWorkerForCloudsIsNeededIfItHasSensors) {
  EXPECT_TRUE(has_clouds(divided("sensors: {roof: {model: velodyne_vlp16}}")));
  EXPECT_FALSE(
      has_clouds(divided("sensors: {left: {model: sick_microscan3, ip_address: 10.0.0.1, ip_port: 6060}}")));
}

}  // namespace
}  // namespace lidard
