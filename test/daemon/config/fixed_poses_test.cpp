// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "daemon/config/config.h"

namespace lidard {
namespace {

VirtualScanConfig group_at(const std::string& base_frame, const std::string& frame, double x) {
  VirtualScanConfig group;
  group.base_frame = base_frame;
  group.virtual_laser_scan = {frame};
  group.poses[frame] = make_pose({x, 0, 0}, {0, 0, 0});
  return group;
}

TEST(FixedPoses, TheFirstEntryThatNamesAFrameCountsAndEachIsThereOnce) {
  Config config;
  config.vehicle.base_frame = "base";
  SensorConfig sensor;
  sensor.name = sensor.frame_id = "roof";
  sensor.pose = make_pose({1, 0, 0}, {0, 0, 0});
  config.sensors = {sensor};
  MergedScanConfig merged;
  merged.destination_frame = "out";
  merged.destination_pose = make_pose({2, 0, 0}, {0, 0, 0});
  config.merged_scans = {merged};
  config.virtual_scans = {group_at("roof", "under", 3), group_at("base", "bumper", 4),
                          group_at("base", "roof", 5), group_at("base", "base", 6)};
  std::vector<std::string> links;
  std::vector<double> x;
  for (const StaticTransform& one : fixed_poses(config)) {
    links.push_back(one.parent + " -> " + one.child);
    x.push_back(one.pose.translation().x());
  }
  EXPECT_EQ(links,
            (std::vector<std::string>{"base -> roof", "base -> out", "roof -> under", "base -> bumper"}));
  EXPECT_EQ(x, (std::vector<double>{1, 2, 3, 4})) << "each in its own parent";
}

}  // namespace
}  // namespace lidard
