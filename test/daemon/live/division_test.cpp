// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/division.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

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

Division divided(const std::string& text) { return Division(parse_config(text, "f")); }

std::vector<std::string> sensors_of(const Config& part) {
  std::vector<std::string> names;
  for (const SensorConfig& sensor : part.sensors) names.push_back(sensor.name);
  return names;
}

std::vector<std::string> topics_of(const Config& part) {
  std::vector<std::string> names;
  for (const OutputTopic& topic : output_topics(part)) {
    if (topic.promised) names.push_back(topic.name);
  }
  return names;
}

TEST(Division, PlanarScannersAndMergedScansStayWithTheSensorThreadCloudsAndVirtualScansDoNot) {
  const Division division = divided(mixed);
  EXPECT_THAT(sensors_of(division.clouds), ElementsAre("low_port", "roof", "camera"))
      << "low_port shares a UDP port";
  EXPECT_THAT(sensors_of(division.planes), ElementsAre("left", "other"));
  EXPECT_THAT(topics_of(division.clouds), ElementsAre("low_port/scan", "roof/points", "roof/scan", "bumper"));
  EXPECT_THAT(topics_of(division.planes), ElementsAre("left/scan", "around"));
  EXPECT_THAT(division.clouds.elsewhere.merged, ElementsAre("bumper", "low_port", "roof"));
  EXPECT_THAT(division.planes.elsewhere.merged, IsEmpty());
}

TEST(Division, EachPartKnowsAllPosesAndThatThereAreFurtherSensors) {
  const Division division = divided(mixed);
  const auto children = [](const Config& part) {
    std::vector<std::string> names;
    for (const StaticTransform& one : fixed_poses(part)) names.push_back(one.child);
    return names;
  };
  EXPECT_THAT(children(division.planes),
              ElementsAre("left", "low_port", "roof", "camera", "other", "bumper"));
  EXPECT_EQ(children(division.clouds), children(division.planes));
  EXPECT_TRUE(division.planes.elsewhere.has_sensors);
  EXPECT_FALSE(divided("sensors: {a: {topic: /a}}").planes.elsewhere.has_sensors);
}

TEST(Division, APlanarScannerOfAMergedCloudGoesWithIt) {
  const Division division = divided(mixed + "merged_clouds:\n  all: {sources: [roof, left, camera]}\n");
  EXPECT_THAT(sensors_of(division.clouds), ElementsAre("left", "low_port", "roof", "camera"));
  EXPECT_EQ(division.clouds.elsewhere.merged.count("left"), 1U);
  EXPECT_THAT(topics_of(division.planes), ElementsAre("around"));
}

TEST(Division, TheVehiclesMotionIsFollowedWhereScansAreMade) {
  const auto moves = [](bool merged, bool cut) {
    Config config = parse_config(mixed, "f");
    if (!merged) config.merged_scans.clear();
    if (!cut) config.virtual_scans.clear();
    const Division division(config);
    return std::pair(division.planes.vehicle.has_motion(), division.clouds.vehicle.has_motion());
  };
  EXPECT_EQ(moves(true, true), std::pair(true, true));
  EXPECT_EQ(moves(false, true), std::pair(false, true));
  EXPECT_EQ(moves(true, false), std::pair(true, false));
  EXPECT_EQ(moves(false, false), std::pair(true, false)) << "one thread reports the state of the motion";
}

}  // namespace
}  // namespace lidard
