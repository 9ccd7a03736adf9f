// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Messages at the limits of what is taken: just within, just beyond, and every word of an enumeration.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "daemon/ros/messages/convert.h"
#include "daemon/ros/messages/device_messages.h"
#include "test/sim/world/units.h"
#include "test/support/ros_samples.h"

namespace lidard {
namespace {

using Field = sensor_msgs::PointField;

TEST(DiagnosticsToRos, EveryHealthHasItsLevel) {
  // diagnostic_msgs/DiagnosticStatus: OK 0, WARN 1, ERROR 2, STALE 3.
  const std::vector<DiagnosticItem> items{{"a", "", Health::ok, "", {}},
                                          {"b", "", Health::warn, "", {}},
                                          {"c", "", Health::error, "", {}},
                                          {"d", "", Health::stale, "", {}}};
  diagnostic_msgs::DiagnosticArray message;
  to_ros(items, "lidard", HostStamp{3'000'000'000}, message);
  ASSERT_EQ(message.status.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(message.status[i].level, static_cast<int>(i)) << message.status[i].name;
    EXPECT_EQ(message.status[i].name, "lidard: " + items[i].name);
  }
  EXPECT_EQ(message.header.stamp, ros::Time(3, 0));
  to_ros({items[1]}, "other", HostStamp{1}, message);
  ASSERT_EQ(message.status.size(), 1U) << "what was in the message before is gone";
  EXPECT_EQ(message.status[0].level, 1);
  EXPECT_EQ(message.status[0].name, "other: b");
}

TEST(DiagnosticsToRos, KeepsTextsAndEveryValueInItsOrder) {
  diagnostic_msgs::DiagnosticArray message;
  to_ros({{"a", "SN", Health::ok, "m", {{"z", "1"}, {"a", "2"}, {"z", "3"}}}}, "n", HostStamp{1}, message);
  EXPECT_EQ(message.status.at(0).hardware_id, "SN");
  EXPECT_EQ(message.status[0].message, "m");
  ASSERT_EQ(message.status[0].values.size(), 3U);
  EXPECT_EQ(message.status[0].values[0].key + message.status[0].values[0].value, "z1");
  EXPECT_EQ(message.status[0].values[1].key + message.status[0].values[1].value, "a2");
  EXPECT_EQ(message.status[0].values[2].key + message.status[0].values[2].value, "z3");
}

TEST(ScanToRos, WritesEachStatusAsItsOutputWantsIt) {
  PlanarScan scan = test::sample_scan();
  scan.none_as = 41;
  scan.invalid_as = 0;
  sensor_msgs::LaserScan message;
  test::to_message(scan, message);
  EXPECT_EQ(message.ranges, (std::vector<float>{1, 41, -inf, 0, 40}));
  scan.none_as = -inf;
  scan.invalid_as = inf;
  test::to_message(scan, message);
  EXPECT_EQ(message.ranges, (std::vector<float>{1, -inf, -inf, inf, 40}));
}

TEST(ScanToRos, HoldsTheFirstEchoOfEachBeamAlone) {
  PlanarScan scan = test::sample_scan();
  scan.reset(3, 2);
  scan.set_angles(0, 0.5F);
  for (std::size_t beam = 0; beam < 3; ++beam) {
    scan.set_hit(scan.index(beam, 0), 1.0F + static_cast<float>(beam));
    scan.set_hit(scan.index(beam, 1), 11.0F + static_cast<float>(beam));
    scan.intensities[scan.index(beam, 0)] = 100 + static_cast<float>(beam);
    scan.intensities[scan.index(beam, 1)] = 200 + static_cast<float>(beam);
  }
  sensor_msgs::LaserScan message;
  test::to_message(scan, message);
  EXPECT_EQ(message.ranges, (std::vector<float>{1, 2, 3}));
  EXPECT_EQ(message.intensities, (std::vector<float>{100, 101, 102}));
  sensor_msgs::MultiEchoLaserScan echoes;
  test::to_message(scan, echoes);
  ASSERT_EQ(echoes.ranges.size(), 3U);
  EXPECT_EQ(echoes.ranges[2].echoes, (std::vector<float>{3, 13}));
  EXPECT_EQ(echoes.intensities[1].echoes, (std::vector<float>{101, 201}));
  // A beam whose first echo is no hit has that alone; a second one that is none is left out.
  scan.set_without_hit(scan.index(1, 1), BeamStatus::none);
  test::to_message(scan, echoes);
  EXPECT_EQ(echoes.ranges[1].echoes, (std::vector<float>{2}));
  EXPECT_EQ(echoes.intensities[1].echoes, (std::vector<float>{101}));
  scan.intensities.clear();
  test::to_message(scan, echoes);
  EXPECT_TRUE(echoes.intensities.empty());
  EXPECT_EQ(echoes.header.frame_id, "front_laser");
  EXPECT_EQ(echoes.angle_max, 1);
  EXPECT_EQ(echoes.range_max, 40);
  EXPECT_EQ(echoes.scan_time, 0.04F);
}

std::string complaint(const sensor_msgs::LaserScan& message) {
  PlanarScan scan;
  const char* why = from_ros(message, scan);
  return why == nullptr ? "" : why;
}

TEST(ScanFromRos, TakesRangesAtTheirLimitsAndInfinitiesByTheirSign) {
  auto message = test::sample_message();
  message.ranges = {0.1F, 40.0F, inf, -inf, nan};
  PlanarScan scan;
  ASSERT_EQ(from_ros(message, scan), nullptr);
  const std::vector<BeamStatus> expected{BeamStatus::hit, BeamStatus::hit, BeamStatus::none, BeamStatus::near,
                                         BeamStatus::invalid};
  EXPECT_EQ(scan.statuses, expected);
  message.ranges = {std::nextafter(0.1F, 0.0F), std::nextafter(40.0F, 50.0F), -1, 0, 1};
  ASSERT_EQ(from_ros(message, scan), nullptr);
  for (const std::size_t i : {0U, 1U, 2U, 3U}) EXPECT_EQ(scan.statuses[i], BeamStatus::invalid) << i;
  EXPECT_EQ(violation(scan), nullptr);
}

TEST(ScanFromRos, MayBeOffByOneBeamFromItsAnglesButNotByTwo) {
  for (const int off : {-2, -1, 0, 1, 2}) {
    auto message = test::sample_message();
    message.ranges.resize(static_cast<std::size_t>(5 + off), 1.0F);
    message.intensities.clear();
    EXPECT_EQ(complaint(message) == "", std::abs(off) <= 1) << off << ": " << complaint(message);
  }
  auto message = test::sample_message();
  message.angle_max += 0.5F;
  PlanarScan scan;
  ASSERT_EQ(from_ros(message, scan), nullptr);
  EXPECT_EQ(scan.angle_max, 1.0F) << "that of the last beam";
}

TEST(ScanFromRos, OfOneBeamNeedsNoIncrement) {
  auto message = test::sample_message();
  message.ranges = {3};
  message.intensities.clear();
  message.angle_increment = 0;
  message.angle_max = 2;
  PlanarScan scan;
  ASSERT_EQ(from_ros(message, scan), nullptr);
  EXPECT_EQ(scan.beams, 1U);
  EXPECT_EQ(scan.ranges[0], 3);
  EXPECT_EQ(violation(scan), nullptr);
}

TEST(ScanFromRos, MayLastAMinuteAndNotLonger) {
  auto message = test::sample_message();
  message.time_increment = 12;
  EXPECT_EQ(complaint(message), "") << "five beams, 60 s";
  message.time_increment = 12.01F;
  EXPECT_EQ(complaint(message), "time_increment makes the scan longer than 60 s");
  message.time_increment = 0;
  EXPECT_EQ(complaint(message), "");
}

TEST(ScanFromRos, RangeLimitsMayBeginAtZeroAndMustDiffer) {
  auto message = test::sample_message();
  message.range_min = 0;
  EXPECT_EQ(complaint(message), "");
  message.range_min = message.range_max;
  EXPECT_EQ(complaint(message), "range limits are not 0 <= min < max");
  message = test::sample_message();
  message.angle_max = inf;
  EXPECT_EQ(complaint(message), "angles are not finite");
  message = test::sample_message();
  message.angle_increment = nan;
  EXPECT_EQ(complaint(message), "angles are not finite");
}

TEST(ScanFromRos, LeavesNothingOfTheMessageBefore) {
  PlanarScan scan;
  ASSERT_EQ(from_ros(test::sample_message(), scan), nullptr);
  auto message = test::sample_message();
  message.intensities.clear();
  message.ranges.assign(5, nan);
  message.header.frame_id = "/other";
  message.header.stamp = ros::Time(7, 0);
  message.scan_time = 0.5F;
  message.range_min = 0.2F;
  message.range_max = 30;
  ASSERT_EQ(from_ros(message, scan), nullptr);
  EXPECT_TRUE(scan.intensities.empty());
  EXPECT_EQ(scan.statuses, std::vector<BeamStatus>(5, BeamStatus::invalid));
  EXPECT_EQ(scan.frame_id, "other");
  EXPECT_EQ(scan.stamp.ns, 7'000'000'000);
  EXPECT_EQ(scan.scan_time, 0.5F);
  EXPECT_EQ(scan.range_min, 0.2F);
  EXPECT_EQ(scan.range_max, 30);
}

TEST(TransformsToRos, HoldARotationThatTurnsAVectorAsThePoseDoes) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-3, 3);
  for (int i = 0; i < 20; ++i) {
    const Pose pose =
        make_pose({any(random), any(random), any(random)}, {any(random), any(random), any(random)});
    tf2_msgs::TFMessage message;
    to_ros({{"/base", "/laser", pose}, {"base", "other", pose}}, HostStamp{1'000'000'000}, message);
    ASSERT_EQ(message.transforms.size(), 2U);
    EXPECT_EQ(message.transforms[0].header.frame_id, "base");
    EXPECT_EQ(message.transforms[0].header.stamp, ros::Time(1, 0));
    EXPECT_EQ(message.transforms[0].child_frame_id, "laser");
    const auto& q = message.transforms[0].transform.rotation;
    const auto& t = message.transforms[0].transform.translation;
    // Rotation by a quaternion, written out (v' = v + 2 u x (u x v + w v), u its vector part).
    const Eigen::Vector3d u(q.x, q.y, q.z), v(1, 2, 3);
    const Eigen::Vector3d turned = v + 2 * u.cross(u.cross(v) + q.w * v);
    EXPECT_TRUE((turned + Eigen::Vector3d(t.x, t.y, t.z)).isApprox(pose * v, 1e-9)) << i;
  }
}

TEST(ImuToRos, HoldsAnOrientationWhereTheDeviceTellsOne) {
  ImuSample sample = test::sample_imu();
  sample.orientation = Eigen::Quaterniond(0.5, -0.5, 0.1, 0.7);
  sensor_msgs::Imu message;
  test::to_message(test::sample_imu(), message);
  test::to_message(sample, message);
  EXPECT_EQ(message.orientation.w, 0.5);
  EXPECT_EQ(message.orientation.x, -0.5);
  EXPECT_EQ(message.orientation.y, 0.1);
  EXPECT_EQ(message.orientation.z, 0.7);
  EXPECT_EQ(message.orientation_covariance[0], 0) << "-1 would say that there is none";
  test::to_message(test::sample_imu(), message);
  EXPECT_EQ(message.orientation.w, 0);
  EXPECT_EQ(message.orientation.z, 0);
  EXPECT_EQ(message.orientation_covariance[0], -1);
}

TEST(StateToRos, OfAMessageThatIsUsedAgainHoldsItsOwnValuesAlone) {
  diagnostic_msgs::DiagnosticArray message;
  test::to_message(DeviceState{"outputs", "laser", Stamp{1}, {{"one", 1}, {"two", 2}, {"three", 3}}},
                   message);
  test::to_message(DeviceState{"fields", "laser", Stamp{2}, {{"four", -0.5}}}, message);
  ASSERT_EQ(message.status.size(), 1U);
  EXPECT_EQ(message.status[0].name, "fields");
  ASSERT_EQ(message.status[0].values.size(), 1U);
  EXPECT_EQ(message.status[0].values[0].key, "four");
  EXPECT_EQ(message.status[0].values[0].value, "-0.5");
}

}  // namespace
}  // namespace lidard
