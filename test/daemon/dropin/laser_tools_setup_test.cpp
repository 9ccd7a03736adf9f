// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/config/config.h"
#include "daemon/dropin/dropin.h"

namespace lidard {
namespace {

using ::testing::ElementsAre;

Config merger_of(const NodeParameters& parameters) {
  return parse_config(laser_merger_setup(parameters).keys.yaml(), "p");
}

Config virtualizer_of(const NodeParameters& parameters) {
  return parse_config(laser_virtualizer_setup(parameters).keys.yaml(), "p");
}

TEST(LaserMerger, HasTheDefaultsOfTheNodeItStandsInFor) {
  const Config config = merger_of({{"laserscan_topics", "/scansx"}});
  ASSERT_EQ(config.merged_scans.size(), 1U);
  const MergedScanConfig& merged = config.merged_scans[0];
  EXPECT_EQ(merged.destination_frame, "cart_frame");
  EXPECT_EQ(merged.scan_destination_topic, "/scan_multi");
  EXPECT_EQ(merged.cloud_destination_topic, "/merged_cloud");
  EXPECT_EQ(merged.output.profile, Profile::flatten);
  EXPECT_EQ(merged.output.empty, EmptyBeam::range_max_plus_one);
  EXPECT_FALSE(merged.output.min_height) << "every height counts";
  const ScanGridSpec& grid = merged.output.grid;
  EXPECT_EQ(grid.angle_min, -2.36);
  EXPECT_EQ(grid.angle_max, 2.36);
  EXPECT_EQ(grid.angle_increment, 0.0058);
  EXPECT_EQ(grid.time_increment, 0);
  EXPECT_EQ(grid.scan_time, 0.0333333);
  EXPECT_EQ(grid.range_min, 0.45);
  EXPECT_EQ(grid.range_max, 25);
}

TEST(LaserMerger, HasTheNumberOfBeamsThatSlamToolboxExpects) {
  const auto beams = [&](const NodeParameters& more) {
    NodeParameters all{{"laserscan_topics", "a"}};
    all.insert(more.begin(), more.end());
    return make_grid(merger_of(all).merged_scans[0].output.grid)->beams;
  };
  // round(span / increment) + 1, for which ira_laser_tools publishes 814 and 690.
  EXPECT_EQ(beams({}), 815U);
  EXPECT_EQ(beams({{"angle_min", "-2.0"}, {"angle_max", "2.0"}}), 691U);
  EXPECT_EQ(beams({{"angle_min", "-3.1416"}, {"angle_max", "3.1416"}}), 1083U) << "a full turn";
}

TEST(LaserVirtualizer, HasTheDefaultsOfTheNodeItStandsInFor) {
  const Config config = virtualizer_of({{"virtual_laser_scan", "scansx scandx"}});
  ASSERT_EQ(config.virtual_scans.size(), 1U);
  const VirtualScanConfig& group = config.virtual_scans[0];
  EXPECT_EQ(config.sensors.at(0).topic, "/cloud_pcd");
  EXPECT_EQ(group.base_frame, "cart_frame");
  EXPECT_THAT(group.virtual_laser_scan, ElementsAre("scansx", "scandx"));
  EXPECT_EQ(group.output_laser_topic, "");
  EXPECT_EQ(group.output.grid.range_max, 25);
  EXPECT_EQ(group.output.empty, EmptyBeam::range_max_plus_one);
  EXPECT_EQ(group.output.min_height, -0.1) << "not the ground too, as in 1.0.7";
}

TEST(LaserVirtualizer, PrefersPrivateParametersToTheAbsoluteOnesOfTheOldNode) {
  const NodeParameters all =
      with_absolute_names({{"cloud_topic", "mine"}, {"angle_max", "1"}},
                          {{"cloud_topic", "theirs"}, {"virtual_laser_scan", "chest"}, {"angle_min", "-1"}});
  EXPECT_EQ(all.at("cloud_topic"), "mine");
  EXPECT_EQ(all.at("virtual_laser_scan"), "chest");
  EXPECT_EQ(all.count("angle_min"), 0U) << "which the old node reads from its private names";
}

}  // namespace
}  // namespace lidard
