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

using test::error_of;

Config parse(const std::string& text) { return parse_config(text, "f"); }
MergedScanConfig merged(const std::string& keys) {
  return parse(sensors + "merged_scans: {m: {" + keys + "}}\n").merged_scans.at(0);
}
std::string error(const std::string& keys) {
  return error_of(sensors + "merged_scans: {m: {" + keys + "}}\n");
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

TEST(ScheduleConfig, RefusesWhatContradictsThePolicy) {
  EXPECT_EQ(error("laserscan_topics: a b, policy: complete, rate: 5"),
            "f:6:61: merged_scans.m.rate has no effect with policy: complete; expected policy: rate");
  EXPECT_EQ(error("laserscan_topics: a b, policy: trigger"),
            "f:6:16: merged_scans.m has no trigger; expected the source whose sweeps trigger the output");
  EXPECT_EQ(error("laserscan_topics: a b, trigger: roof"),
            "f:6:52: merged_scans.m.trigger is \"roof\", which is no source of it; expected one of "
            "laserscan_topics: a b");
  EXPECT_EQ(error("laserscan_topics: a b, policy: often"),
            "f:6:51: merged_scans.m.policy is \"often\"; expected complete, rate or trigger");
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
  EXPECT_EQ(
      error("laserscan_topics: a b, source_settings: {a: {range_min: 3, range_max: 2}}"),
      "f:6:90: merged_scans.m.source_settings.a.range_max leaves nothing between range_min and range_max; "
      "expected range_min < range_max");
  EXPECT_NE(error("laserscan_topics: a b, source_settings: {c: {}}").find("source_settings"),
            std::string::npos);
}

TEST(ScheduleConfig, SourcesMayBeVirtualScansAndSingleRings) {
  EXPECT_EQ(merged("laserscan_topics: [a, low, roof]").laserscan_topics,
            (std::vector<std::string>{"a", "low", "roof"}));
  EXPECT_EQ(
      error("laserscan_topics: [a, low], profile: strict"),
      "f:6:42: merged_scans.m.laserscan_topics[1] names \"low\", a virtual scan of profile flatten, which "
      "proves nothing; expected a virtual scan of profile strict or safety, or profile: flatten here");
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
  const auto refused = [](const std::string& keys) {
    return error_of("vehicle: {" + keys + "}\n" + sensors);
  };
  EXPECT_FALSE(vehicle("base_frame: base").has_motion());
  EXPECT_TRUE(vehicle("odometry_topic: /odom").has_motion());
  EXPECT_EQ(vehicle("imu_topic: imu, speed_topic: speed").speed_topic, "speed");
  EXPECT_EQ(refused("odometry_frame: odom, odometry_topic: /odom"),
            "f:1:33: vehicle.odometry_topic is a second source of motion; expected one of odometry_frame, "
            "odometry_topic, or imu_topic with speed_topic");
  EXPECT_EQ(
      refused("imu_topic: imu"),
      "f:1:11: vehicle.imu_topic stands alone; expected imu_topic (turn rates) and speed_topic together");
}

}  // namespace
}  // namespace lidard
