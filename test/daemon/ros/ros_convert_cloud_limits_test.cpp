// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Cloud messages at the limits of what is taken: just within, just beyond, and used again.
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

/// A cloud message of points with a ring as float64 and a time as float32, row after row.
struct RingMessage {
  explicit RingMessage(std::size_t points) {
    for (const auto& [name, type, offset] : std::vector<std::tuple<const char*, std::uint8_t, std::uint32_t>>{
             {"x", Field::FLOAT32, 0},
             {"y", Field::FLOAT32, 4},
             {"z", Field::FLOAT32, 8},
             {"ring", Field::FLOAT64, 12},
             {"time", Field::FLOAT32, 20},
             {"intensity", Field::FLOAT32, 24}}) {
      Field field;
      field.name = name, field.datatype = type, field.offset = offset, field.count = 1;
      message.fields.push_back(field);
    }
    message.height = 1;
    message.width = static_cast<std::uint32_t>(points);
    message.point_step = 28;
    message.row_step = 28 * message.width;
    message.data.resize(28 * points);
    message.header.stamp = ros::Time(100, 0);
  }
  void set(std::size_t point, double ring, float time, float intensity = 1) {
    std::uint8_t* bytes = message.data.data() + 28 * point;
    const float xyz[] = {1, 2, 3};
    std::memcpy(bytes, xyz, 12);
    std::memcpy(bytes + 12, &ring, 8);
    std::memcpy(bytes + 20, &time, 4);
    std::memcpy(bytes + 24, &intensity, 4);
  }
  Cloud read() const {
    Cloud cloud;
    EXPECT_EQ(from_ros(message, cloud).error, nullptr);
    return cloud;
  }
  sensor_msgs::PointCloud2 message;
};

TEST(CloudFromRos, BringsRingsThatAreOutOfRangeToTheNearestThatIsIn) {
  RingMessage given(6);
  const double rings[] = {-1, -1e300, 65535, 65536, 1e300, std::numeric_limits<double>::quiet_NaN()};
  const int expected[] = {0, 0, 65535, 65535, 65535, 0};
  for (std::size_t i = 0; i < 6; ++i) given.set(i, rings[i], 0);
  const Cloud cloud = given.read();
  ASSERT_EQ(cloud.size(), 6U);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(int(cloud.points()[i].ring), expected[i]) << rings[i];
  EXPECT_EQ(cloud.rings, 65535);
}

TEST(CloudFromRos, HasOneRingMoreThanItsHighestNumber) {
  RingMessage given(2);
  given.set(0, 4, 0);
  given.set(1, 2, 0);
  EXPECT_EQ(given.read().rings, 5);
  given.set(0, 0, 0);
  given.set(1, 0, 0);
  EXPECT_EQ(given.read().rings, 1);
}

TEST(CloudFromRos, TimesUpToAMinuteFromTheStampAreTheCloudsOwn) {
  const struct {
    float first, last;
    bool own;
  } cases[] = {{0, 60, true}, {0, 60.01F, false}, {-60, 0, true}, {-60.01F, 0, false}, {-0.1F, 0.05F, true}};
  for (const auto& one : cases) {
    RingMessage given(2);
    given.set(0, 0, one.last);
    given.set(1, 0, one.first);
    const Cloud cloud = given.read();
    const double before = one.own ? std::min(0.0, static_cast<double>(one.first)) : 0;
    const double length = one.own ? static_cast<double>(one.last) - before : 0;
    EXPECT_NEAR(seconds(cloud.stamp - Stamp{100'000'000'000}), before, 1e-5) << one.first;
    EXPECT_NEAR(seconds(cloud.end - cloud.stamp), length, 1e-5) << one.first;
    EXPECT_NEAR(double(cloud.points()[0].time), length, 1e-5) << one.first;
    EXPECT_NEAR(double(cloud.points()[1].time), one.own ? static_cast<double>(one.first) - before : 0, 1e-5);
  }
}

TEST(CloudFromRos, TimesThatAllLieAfterTheStampStayWhereTheyAre) {
  RingMessage given(2);
  given.set(0, 0, 0.02F);
  given.set(1, 0, 0.08F);
  const Cloud cloud = given.read();
  EXPECT_EQ(cloud.stamp.ns, 100'000'000'000);
  EXPECT_NEAR(seconds(cloud.end - cloud.stamp), 0.08, 1e-6);
  EXPECT_EQ(float(cloud.points()[0].time), 0.02F);
}

TEST(CloudFromRos, ValuesThatAreNotFiniteCountAsZero) {
  RingMessage given(1);
  given.set(0, 3, nan, inf);
  const Cloud cloud = given.read();
  EXPECT_EQ(float(cloud.points()[0].intensity), 0);
  EXPECT_EQ(float(cloud.points()[0].time), 0);
  EXPECT_EQ(cloud.end, cloud.stamp);
}

TEST(CloudFromRos, LeavesOutCoordinatesThatNoFloatHolds) {
  sensor_msgs::PointCloud2 message;
  for (std::uint32_t i = 0; i < 3; ++i) {
    Field field;
    field.name = std::string(1, static_cast<char>('x' + i)), field.datatype = Field::FLOAT64;
    field.offset = 8 * i, field.count = 0;
    message.fields.push_back(field);
  }
  message.height = message.width = 1;
  message.point_step = message.row_step = 24;
  message.data.resize(24);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const double value : {1e39, -1e39, 3e38}) {
      std::fill(message.data.begin(), message.data.end(), std::uint8_t{0});
      std::memcpy(message.data.data() + 8 * axis, &value, 8);
      Cloud cloud;
      EXPECT_EQ(from_ros(message, cloud).dropped, std::abs(value) > 3.5e38 ? 1U : 0U)
          << axis << ", " << value;
    }
  }
}

TEST(CloudFromRos, TakesDataThatEndExactlyWhereTheyMay) {
  // The last row of a message needs no padding.
  RingMessage given(4);
  for (std::size_t i = 0; i < 4; ++i) given.set(i, static_cast<double>(i), 0);
  given.message.height = 2;
  given.message.width = 2;
  given.message.row_step = 56;
  EXPECT_EQ(given.read().size(), 4U);
  given.message.data.pop_back();
  Cloud cloud;
  EXPECT_NE(from_ros(given.message, cloud).error, nullptr);
  given.message.height = 1;
  given.message.row_step = 0;
  EXPECT_EQ(given.read().size(), 2U) << "of a single row, row_step says nothing";
}

}  // namespace
}  // namespace lidard
