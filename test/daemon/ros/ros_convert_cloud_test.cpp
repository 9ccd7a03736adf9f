// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>

#include "daemon/ros/messages/convert.h"
#include "test/support/ros_samples.h"

namespace lidard {
namespace {

using Field = sensor_msgs::PointField;
using test::sample_cloud;

/// Builds a message field by field, in the order and types a test asks for.
class CloudMaker {
 public:
  CloudMaker& field(const char* name, std::uint8_t type, std::uint32_t offset) {
    Field made;
    made.name = name;
    made.datatype = type;
    made.offset = offset;
    made.count = 1;
    message.fields.push_back(made);
    return *this;
  }
  CloudMaker& size(std::uint32_t height, std::uint32_t width, std::uint32_t point_step,
                   std::uint32_t padding = 0) {
    message.height = height;
    message.width = width;
    message.point_step = point_step;
    message.row_step = width * point_step + padding;
    message.data.resize(static_cast<std::size_t>(message.row_step) * height);
    return *this;
  }
  template <typename T>
  CloudMaker& put(std::size_t at, T value) {
    auto* bytes = message.data.data() + at;
    std::memcpy(bytes, &value, sizeof value);
    if (message.is_bigendian) std::reverse(bytes, bytes + sizeof value);
    return *this;
  }
  CloudMaker& xyz(std::size_t at, float x, float y, float z) {
    return put(at, x).put(at + 4, y).put(at + 8, z);
  }

  sensor_msgs::PointCloud2 message;
};

CloudMaker plain(std::uint32_t points) {
  CloudMaker maker;
  maker.field("x", Field::FLOAT32, 0)
      .field("y", Field::FLOAT32, 4)
      .field("z", Field::FLOAT32, 8)
      .size(1, points, 12);
  return maker;
}

std::string reason(const sensor_msgs::PointCloud2& message) {
  Cloud cloud;
  const auto reading = from_ros(message, cloud);
  return reading.error == nullptr ? "" : reading.error;
}

TEST(CloudFromRos, GivesBackOurOwnCloudByteForByte) {
  Cloud sent = sample_cloud(100);
  const auto bytes = sent.points_bytes;
  const sensor_msgs::PointCloud2 message = test::message_of(sent);
  Cloud cloud;
  const auto reading = from_ros(message, cloud);
  ASSERT_EQ(reading.error, nullptr);
  EXPECT_EQ(reading.dropped, 0U);
  EXPECT_EQ(cloud.points_bytes, bytes);
  EXPECT_EQ(cloud.frame_id, "velodyne");
  EXPECT_EQ(cloud.stamp, sent.stamp);
  EXPECT_EQ(cloud.end, sent.stamp + span_from_seconds(static_cast<double>(99 * 1e-4F)));
  EXPECT_EQ(cloud.rings, 16);
  EXPECT_TRUE(cloud.complete);
}

TEST(CloudFromRos, ReadsAnyOrderAndType) {
  CloudMaker maker;
  maker.field("ring", Field::UINT8, 0).field("rgb", Field::FLOAT32, 1).field("z", Field::FLOAT64, 5);
  maker.field("y", Field::INT16, 13).field("intensity", Field::UINT32, 15).field("x", Field::INT8, 19);
  maker.field("time", Field::FLOAT64, 20).size(1, 1, 28);
  maker.put(0, std::uint8_t{9})
      .put(5, 2.5)
      .put(13, std::int16_t{-300})
      .put(15, 70000U)
      .put(19, std::int8_t{-4});
  maker.put(20, 0.25);
  Cloud cloud;
  ASSERT_EQ(from_ros(maker.message, cloud).error, nullptr);
  ASSERT_EQ(cloud.size(), 1U);
  const CloudPoint p = cloud.points()[0];
  EXPECT_EQ(float(p.x), -4);
  EXPECT_EQ(float(p.y), -300);
  EXPECT_EQ(float(p.z), 2.5F);
  EXPECT_EQ(float(p.intensity), 70000);
  EXPECT_EQ(std::uint16_t(p.ring), 9);
  EXPECT_EQ(float(p.time), 0.25F);
}

TEST(CloudFromRos, ReadsBigEndianRowsWithPadding) {
  CloudMaker maker;
  maker.message.is_bigendian = true;
  maker.field("x", Field::FLOAT32, 0).field("y", Field::FLOAT32, 4).field("z", Field::FLOAT32, 8);
  maker.field("ring", Field::UINT16, 12).size(2, 1, 16, 8);
  maker.xyz(0, 1, 2, 3).put(12, std::uint16_t{258}).xyz(24, 4, 5, 6).put(36, std::uint16_t{3});
  Cloud cloud;
  ASSERT_EQ(from_ros(maker.message, cloud).error, nullptr);
  ASSERT_EQ(cloud.size(), 2U);
  EXPECT_EQ(std::uint16_t(cloud.points()[0].ring), 258);
  EXPECT_EQ(float(cloud.points()[1].x), 4);
  EXPECT_EQ(float(cloud.points()[1].z), 6);
}

TEST(CloudFromRos, LeavesOutPointsThatAreNotFiniteAndCountsThem) {
  auto maker = plain(4);
  maker.xyz(0, 1, 2, 3).xyz(12, std::numeric_limits<float>::quiet_NaN(), 0, 0);
  maker.xyz(24, 0, std::numeric_limits<float>::infinity(), 0).xyz(36, 4, 5, 6);
  Cloud cloud;
  const auto reading = from_ros(maker.message, cloud);
  ASSERT_EQ(reading.error, nullptr);
  EXPECT_EQ(reading.dropped, 2U);
  ASSERT_EQ(cloud.size(), 2U);
  EXPECT_EQ(float(cloud.points()[1].x), 4);
}

TEST(CloudFromRos, TakesAnEmptyCloud) {
  Cloud cloud = sample_cloud(3);
  ASSERT_EQ(from_ros(plain(0).message, cloud).error, nullptr);
  EXPECT_EQ(cloud.size(), 0U);
}

TEST(CloudFromRos, RefusesALayoutThatLies) {
  auto message = plain(2).message;
  EXPECT_EQ(reason(message), "");
  message.data.pop_back();
  EXPECT_EQ(reason(message), "less data than height, width, point_step and row_step say");
  message = plain(2).message;
  message.point_step = 11;
  EXPECT_EQ(reason(message), "a field lies outside point_step");
  message = plain(2).message;
  message.fields[2].offset = std::numeric_limits<std::uint32_t>::max();
  EXPECT_EQ(reason(message), "a field lies outside point_step");
  message = plain(2).message;
  message.height = 2;
  message.row_step = 4;
  EXPECT_EQ(reason(message), "row_step is less than width x point_step");
  message = plain(2).message;
  message.width = message.height = message.row_step = message.point_step =
      std::numeric_limits<std::uint32_t>::max();
  EXPECT_NE(reason(message), "");
}

TEST(CloudFromRos, RefusesFieldsItCannotRead) {
  auto message = plain(1).message;
  message.fields.pop_back();
  EXPECT_EQ(reason(message), "no fields x, y and z");
  message = plain(1).message;
  message.fields[0].datatype = 99;
  EXPECT_EQ(reason(message), "a field has an unknown datatype");
  message = plain(1).message;
  message.fields[0].count = 3;
  EXPECT_EQ(reason(message), "a field that should hold one value holds several");
}

}  // namespace
}  // namespace lidard
