// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "test/daemon/config/config_support.h"

namespace lidard {
namespace {

const std::string sensors =
    "sensors:\n"
    "  a: {model: sick_microscan3, pose: {xyz: [0, 1, 0]}}\n"
    "  b: {topic: /b/scan, pose: {xyz: [0, -1, 0]}}\n"
    "  roof: {model: velodyne_vlp16, ip_port: 2370, pose: {xyz: [0, 0, 2]}, scan_ring: auto}\n"
    "virtual_scans: {v: {cloud_topic: roof, virtual_laser_scan: [low], poses: {low: {xyz: [0, 0, 0.3]}}}}\n";

Config parse(const std::string& text) { return parse_config(text, "f"); }
MergedScanConfig merged(const std::string& keys) {
  return parse(sensors + "merged_scans: {m: {" + keys + "}}\n").merged_scans.at(0);
}

TEST(ScheduleConfig, IsCompleteByDefaultAndTakesItsKindFromRateOrTrigger) {
  EXPECT_EQ(merged("laserscan_topics: a b").schedule.policy, Policy::complete);
  const auto rate = merged("laserscan_topics: a b, rate: 20, deadline: 0.01").schedule;
  EXPECT_EQ(rate.policy, Policy::rate);
  EXPECT_EQ(rate.rate, 20);
  EXPECT_EQ(rate.deadline, std::chrono::milliseconds(10));
  const auto trigger = merged("laserscan_topics: a b, trigger: b").schedule;
  EXPECT_EQ(trigger.policy, Policy::trigger);
  EXPECT_EQ(trigger.trigger, 1U);
  EXPECT_EQ(merged("laserscan_topics: a, on_missing_motion: wait").on_missing_motion, MissingMotion::wait);
}

TEST(ScheduleConfig, SourcesHaveWindowsOfTheirOwn) {
  const auto config = merged(
      "laserscan_topics: a b, range_noise: 0.03, source_settings: {a: {range_min: 0.4, range_max: 8, "
      "angle_min_deg: "
      "-90, angle_max_deg: 90, no_return_free_range: 0}}");
  const SourceSettings& a = config.source_settings.at("a");
  EXPECT_EQ(a.range_max, 8);
  EXPECT_NEAR(a.angle_max.value_or(0), 1.5707963, 1e-6);
  EXPECT_EQ(a.no_return_free_range, 0);
  EXPECT_EQ(a.noise, 0.03);
  EXPECT_EQ(config.source_settings.count("b"), 0U);
}

TEST(ScheduleConfig, SourcesMayBeVirtualScansAndSingleRings) {
  EXPECT_EQ(merged("laserscan_topics: [a, low, roof]").laserscan_topics,
            (std::vector<std::string>{"a", "low", "roof"}));
}

TEST(ScheduleConfig, VirtualScanIsNamedAsItIsPublishedWithOrWithoutASlash) {
  const std::string text =
      "sensors: {roof: {model: velodyne_vlp16, pose: {xyz: [0, 0, 2]}}}\n"
      "virtual_scans: {v: {cloud_topic: roof, virtual_laser_scan: [low], output_laser_topic: /cut}}\n";
  for (const char* name : {"cut", "/cut"}) {
    const Config config = parse(text + "merged_scans: {m: {laserscan_topics: [" + name + "]}}\n");
    EXPECT_EQ(config.merged_scans.at(0).laserscan_topics, std::vector<std::string>{"/cut"}) << name;
  }
}

TEST(MotionConfig, HasOneSource) {
  const auto vehicle = [](const std::string& keys) {
    return parse("vehicle: {" + keys + "}\n" + sensors).vehicle;
  };
  EXPECT_FALSE(vehicle("base_frame: base").has_motion());
  EXPECT_TRUE(vehicle("odometry_topic: /odom").has_motion());
  EXPECT_EQ(vehicle("imu_topic: imu, speed_topic: speed").speed_topic, "speed");
}

}  // namespace
}  // namespace lidard
