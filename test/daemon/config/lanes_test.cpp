// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config/lanes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace lidard {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

template <class Entries>
std::vector<std::string> names(const Entries& entries) {
  std::vector<std::string> all;
  for (const auto& entry : entries) all.push_back(entry.name);
  return all;
}

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

TEST(Lanes, PlanarScannersAndMergedScansGoOneWayCloudsAndVirtualScansTheOther) {
  const Config all = parse_config(mixed, "f");
  const Config planes = part_of(all, Lane::planes), clouds = part_of(all, Lane::clouds);
  EXPECT_THAT(names(clouds.sensors), ElementsAre("low_port", "roof", "camera"))
      << "low_port shares a UDP port";
  EXPECT_THAT(names(clouds.virtual_scans), ElementsAre("levels"));
  EXPECT_THAT(names(clouds.merged_scans), IsEmpty());
  EXPECT_THAT(clouds.hand_over, ElementsAre("bumper", "low_port", "roof"));
  EXPECT_THAT(names(planes.sensors), ElementsAre("left", "other"));
  EXPECT_EQ(planes.handed_over, clouds.hand_over);
  EXPECT_THAT(names(planes.merged_scans), ElementsAre("around"));
  EXPECT_THAT(names(planes.virtual_scans), IsEmpty());
}

TEST(Lanes, APlanarScannerOfAMergedCloudGoesWithItAndIsHandedOverToMergedScans) {
  std::string text = mixed;
  text += "merged_clouds:\n  all: {sources: [roof, left, camera]}\n";
  const Config all = parse_config(text, "f");
  const Config planes = part_of(all, Lane::planes), clouds = part_of(all, Lane::clouds);
  EXPECT_THAT(names(clouds.sensors), ElementsAre("left", "low_port", "roof", "camera"));
  EXPECT_THAT(names(clouds.merged_clouds), ElementsAre("all"));
  EXPECT_THAT(names(planes.merged_clouds), IsEmpty());
  EXPECT_THAT(clouds.hand_over, ElementsAre("bumper", "left", "low_port", "roof"));
  Config only_clouds = all;
  only_clouds.virtual_scans.clear();
  only_clouds.merged_scans.clear();
  EXPECT_TRUE(part_of(only_clouds, Lane::clouds).vehicle.has_motion());
}

TEST(Lanes, BothKnowAllPoses) {
  const Config all = parse_config(mixed, "f");
  for (const Lane lane : {Lane::planes, Lane::clouds})
    EXPECT_EQ(fixed_poses(part_of(all, lane)).size(), fixed_poses(all).size());
}

TEST(Lanes, TheVehiclesMotionIsFollowedWhereScansAreMade) {
  Config all = parse_config(mixed, "f");
  EXPECT_TRUE(part_of(all, Lane::planes).vehicle.has_motion());
  EXPECT_TRUE(part_of(all, Lane::clouds).vehicle.has_motion());
  Config only_virtual = all, only_merged = all;
  only_virtual.merged_scans.clear();
  only_merged.virtual_scans.clear();
  EXPECT_FALSE(part_of(only_virtual, Lane::planes).vehicle.has_motion());
  EXPECT_TRUE(part_of(only_virtual, Lane::clouds).vehicle.has_motion());
  EXPECT_TRUE(part_of(only_merged, Lane::planes).vehicle.has_motion());
  EXPECT_FALSE(part_of(only_merged, Lane::clouds).vehicle.has_motion());
  all.merged_scans.clear();
  all.virtual_scans.clear();
  EXPECT_TRUE(part_of(all, Lane::planes).vehicle.has_motion()) << "the motion's state is told by somebody";
}

TEST(Lanes, APartThatHasNothingToDoIsEmpty) {
  const Config all = parse_config("sensors: {roof: {model: velodyne_vlp16}}", "f");
  EXPECT_THAT(names(part_of(all, Lane::planes).sensors), IsEmpty());
  EXPECT_THAT(names(part_of(all, Lane::clouds).sensors), ElementsAre("roof"));
}

}  // namespace
}  // namespace lidard
