// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "daemon/ros/messages/device_messages.h"
#include "test/support/ros_samples.h"

namespace lidard {
namespace {

TEST(FixToRos, CopiesEveryFieldAndKnowsNoCovariance) {
  sensor_msgs::NavSatFix message;
  test::to_message(test::sample_fix(), message);
  EXPECT_EQ(message.header.stamp, ros::Time(1'700'000'000, 367'120'000));
  EXPECT_EQ(message.header.frame_id, "velodyne");
  EXPECT_EQ(message.latitude, 36.82913093);
  EXPECT_EQ(message.longitude, -2.40757155);
  EXPECT_EQ(message.altitude, 59.5);
  EXPECT_EQ(message.status.status, sensor_msgs::NavSatStatus::STATUS_SBAS_FIX);
  EXPECT_EQ(message.status.service, sensor_msgs::NavSatStatus::SERVICE_GPS);
  EXPECT_EQ(message.position_covariance_type, sensor_msgs::NavSatFix::COVARIANCE_TYPE_UNKNOWN);
  for (const double value : message.position_covariance) EXPECT_EQ(value, 0);
}

TEST(FixToRos, TellsHowThePositionWasFound) {
  using Status = sensor_msgs::NavSatStatus;
  const auto status = [](FixStatus given) {
    GnssFix fix;
    fix.status = given;
    sensor_msgs::NavSatFix message;
    test::to_message(fix, message);
    return message.status.status;
  };
  EXPECT_EQ(status(FixStatus::none), Status::STATUS_NO_FIX);
  EXPECT_EQ(status(FixStatus::satellite), Status::STATUS_FIX);
  EXPECT_EQ(status(FixStatus::sbas), Status::STATUS_SBAS_FIX);
  EXPECT_EQ(status(FixStatus::gbas), Status::STATUS_GBAS_FIX);
}

TEST(FixToRos, WithoutAPositionIsNotANumber) {
  sensor_msgs::NavSatFix message;
  test::to_message(test::sample_fix(), message);
  test::to_message(GnssFix{}, message);
  EXPECT_TRUE(std::isnan(message.latitude));
  EXPECT_TRUE(std::isnan(message.longitude));
  EXPECT_TRUE(std::isnan(message.altitude));
  EXPECT_EQ(message.status.status, sensor_msgs::NavSatStatus::STATUS_NO_FIX);
}

TEST(TimeReferenceToRos, HoldsBothClocksAndTheSource) {
  sensor_msgs::TimeReference message;
  test::to_message(test::sample_time_reference(), message);
  EXPECT_EQ(message.header.stamp, ros::Time(1'700'000'000, 709'121'000));
  EXPECT_EQ(message.time_ref, ros::Time(1'700'000'000, 342'001'000));
  EXPECT_EQ(message.source, "gps_pps");
}

TEST(ImuToRos, HasNoOrientation) {
  sensor_msgs::Imu message;
  test::to_message(test::sample_imu(), message);
  EXPECT_EQ(message.header.stamp, ros::Time(1'700'000'000, 380'293'000));
  EXPECT_EQ(message.header.frame_id, "velodyne");
  EXPECT_EQ(message.orientation_covariance[0], -1);
  EXPECT_EQ(message.angular_velocity.x, 0.01);
  EXPECT_EQ(message.angular_velocity.y, -0.02);
  EXPECT_EQ(message.angular_velocity.z, 0.3);
  EXPECT_EQ(message.linear_acceleration.x, 0.5);
  EXPECT_EQ(message.linear_acceleration.y, -0.25);
  EXPECT_EQ(message.linear_acceleration.z, 9.8);
  EXPECT_EQ(message.angular_velocity_covariance[0], 0);
  EXPECT_EQ(message.linear_acceleration_covariance[0], 0);
}

}  // namespace
}  // namespace lidard
