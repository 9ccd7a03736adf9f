// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

#include "daemon/ros/messages/convert.h"
#include "daemon/ros/out/message_rows.h"
#include "test/sim/world/units.h"
#include "test/support/ros_samples.h"

namespace lidard {
namespace {

using namespace std::chrono_literals;
using test::sample_cloud;
using test::sample_message;
using test::sample_scan;

TEST(MessageRows, EveryKindOfTopicAndOfMessageHasOne) {
  for (std::size_t kind = 0; kind < std::variant_size_v<DeviceMessage>; ++kind)
    EXPECT_NE(row_of({"t", TopicKind::message, true, kind}).maker()->type().name, "");
  for (const TopicKind kind : {TopicKind::scan, TopicKind::echoes, TopicKind::cloud, TopicKind::merged_cloud,
                               TopicKind::extended_scan, TopicKind::output_paths})
    EXPECT_NE(row_of({"t", kind}).maker()->type().name, "");
}

TEST(MessageRows, StampEveryMessageByTheHostsClockAndReadItBack) {
  const ClockStep clock(-5s);
  const Cloud cloud = test::sample_cloud(3);
  const sensor_msgs::PointCloud2 message = test::message_of(cloud, -5s);
  EXPECT_EQ(message.header.stamp, to_ros(HostStamp{(cloud.stamp - 5s).ns}));
  Cloud read;
  ASSERT_EQ(from_ros(message, read, clock).error, nullptr);
  EXPECT_EQ(read.stamp, cloud.stamp);
  const DeviceMessage reference = test::sample_time_reference();
  const RawMessage made = row_of(test::roof_time).maker()->make(reference, Stamp(), clock);
  sensor_msgs::TimeReference sent;
  ros::serialization::IStream stream(made.data.message_start, made.size());
  ros::serialization::deserialize(stream, sent);
  EXPECT_EQ(sent.header.stamp, to_ros(HostStamp{(test::sample_time_reference().stamp - 5s).ns}));
  EXPECT_EQ(sent.time_ref, to_ros(test::sample_time_reference().reference)) << "the other clock was not set";
}

TEST(RosTime, KeepsNanosecondsAndMovesWhatRosCannotHoldToTheNearestEnd) {
  EXPECT_EQ(to_ros(HostStamp{1'600'000'000'123'456'789}), ros::Time(1'600'000'000, 123'456'789));
  EXPECT_EQ(from_ros(to_ros(HostStamp{1'600'000'000'123'456'789})).ns, 1'600'000'000'123'456'789);
  EXPECT_EQ(to_ros(HostStamp{-5}), ros::Time(0, 0));
  EXPECT_EQ(to_ros(HostStamp{std::numeric_limits<std::int64_t>::max()}),
            ros::Time(4294967295U, 999'999'999U));
}

TEST(RosFrame, NeverBeginsWithASlash) {
  EXPECT_EQ(ros_frame("/laser"), "laser");
  EXPECT_EQ(ros_frame("//a/b"), "a/b");
  EXPECT_EQ(ros_frame("laser"), "laser");
  EXPECT_EQ(ros_frame("/"), "");
}

TEST(ScanToRos, CopiesEveryField) {
  const auto message = sample_message();
  EXPECT_EQ(message.header.frame_id, "front_laser");
  EXPECT_EQ(message.header.stamp, ros::Time(1'700'000'000, 5));
  EXPECT_EQ(message.angle_min, -1.0F);
  EXPECT_EQ(message.angle_increment, 0.5F);
  EXPECT_EQ(message.angle_max, 1.0F);
  EXPECT_EQ(message.time_increment, 1e-4F);
  EXPECT_EQ(message.scan_time, 0.04F);
  EXPECT_EQ(message.range_min, 0.1F);
  EXPECT_EQ(message.range_max, 40.0F);
  ASSERT_EQ(message.ranges.size(), 5U);
  EXPECT_EQ(message.ranges[0], 1.0F);
  EXPECT_EQ(message.ranges[1], inf);
  EXPECT_EQ(message.ranges[2], -inf);
  EXPECT_TRUE(std::isnan(message.ranges[3]));
  EXPECT_EQ(message.intensities, (std::vector<float>{10, 20, 30, 40, 50}));
}

TEST(ScanToRos, HasNoIntensitiesWhereTheScanHasNone) {
  auto scan = sample_scan();
  scan.intensities.clear();
  sensor_msgs::LaserScan message;
  message.intensities.resize(3);
  test::to_message(scan, message);
  EXPECT_TRUE(message.intensities.empty());
}

TEST(ScanFromRos, GivesBackWhatWasSent) {
  PlanarScan scan;
  ASSERT_EQ(from_ros(sample_message(), scan), nullptr);
  EXPECT_EQ(violation(scan), nullptr);
  const auto sent = sample_scan();
  EXPECT_EQ(scan.frame_id, sent.frame_id);
  EXPECT_EQ(scan.stamp, sent.stamp);
  EXPECT_EQ(scan.statuses, sent.statuses);
  EXPECT_EQ(scan.intensities, sent.intensities);
  EXPECT_EQ(scan.angle_max, sent.angle_max);
  EXPECT_EQ(scan.time_increment, sent.time_increment);
}

TEST(ScanFromRos, KeepsAScannerMountedUpsideDown) {
  auto message = sample_message();
  message.angle_min = 1.0F;
  message.angle_max = -1.0F;
  message.angle_increment = -0.5F;
  PlanarScan scan;
  ASSERT_EQ(from_ros(message, scan), nullptr);
  EXPECT_EQ(scan.angle_increment, -0.5F);
  EXPECT_EQ(violation(scan), nullptr);
}

TEST(ScanFromRos, LeavesOutIntensitiesOfTheWrongNumber) {
  for (const std::size_t n : {2U, 9U}) {
    auto message = sample_message();
    message.intensities.resize(n);
    PlanarScan scan;
    EXPECT_FALSE(intensities_fit(message));
    ASSERT_EQ(from_ros(message, scan), nullptr);
    EXPECT_TRUE(scan.intensities.empty());
    EXPECT_EQ(scan.statuses, sample_scan().statuses);
    EXPECT_EQ(violation(scan), nullptr);
  }
  EXPECT_TRUE(intensities_fit(sample_message()));
}

TEST(ScanFromRos, TakesAMessageWithoutRangesAsASweepThatSaysNothing) {
  auto message = sample_message();
  message.ranges.clear();
  message.intensities.clear();
  message.angle_max = message.angle_min - 1;  // of no meaning without ranges
  PlanarScan scan;
  ASSERT_EQ(from_ros(message, scan), nullptr);
  EXPECT_EQ(scan.beams, 0U);
  EXPECT_EQ(scan.stamp, sample_scan().stamp);
}

TEST(ScanFromRos, BeamsComeInTheOrderInWhichTheyWereMeasured) {
  auto message = sample_message();
  message.time_increment = -0.25F;
  PlanarScan scan;
  ASSERT_EQ(from_ros(message, scan), nullptr);
  const PlanarScan plain = sample_scan();
  const std::size_t last = plain.beams - 1;
  EXPECT_EQ(scan.time_increment, 0.25F);
  EXPECT_EQ(scan.angle_increment, -plain.angle_increment);
  EXPECT_EQ(scan.stamp, plain.stamp - span_from_seconds(0.25 * static_cast<double>(last)));
  for (std::size_t beam = 0; beam <= last; ++beam)
    EXPECT_EQ(scan.statuses[beam], plain.statuses[last - beam]);
}

TEST(ScanFromRos, SaysWhatIsWrong) {
  const auto broken = [](auto&& change) {
    auto message = sample_message();
    change(message);
    PlanarScan scan;
    const char* reason = from_ros(message, scan);
    return std::string(reason == nullptr ? "" : reason);
  };
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(broken([](auto&) {}), "");
  EXPECT_EQ(broken([](auto& m) { m.angle_min = nan; }), "angles are not finite");
  EXPECT_EQ(broken([](auto& m) { m.angle_increment = 0; }), "angle_increment is 0");
  EXPECT_EQ(broken([](auto& m) { m.angle_increment = -0.5F; }),
            "angle_increment has the wrong sign for angle_min and angle_max");
  EXPECT_EQ(broken([](auto& m) { m.ranges.resize(9); }),
            "number of ranges does not fit angle_min, angle_max and angle_increment");
  EXPECT_EQ(broken([](auto& m) { m.time_increment = nan; }), "time_increment is not finite");
  EXPECT_EQ(broken([](auto& m) { m.time_increment = 20; }), "time_increment makes the scan longer than 60 s");
  EXPECT_EQ(broken([](auto& m) { m.time_increment = -20; }),
            "time_increment makes the scan longer than 60 s");
  EXPECT_EQ(broken([](auto& m) { m.time_increment = inf; }), "time_increment is not finite");
  EXPECT_EQ(broken([](auto& m) { m.scan_time = inf; }), "scan_time is not finite");
  EXPECT_EQ(broken([](auto& m) { m.range_max = nan; }), "range limits are not 0 <= min < max");
  EXPECT_EQ(broken([](auto& m) { m.range_min = -1; }), "range limits are not 0 <= min < max");
}

TEST(CloudToRos, HasTheContractsLayoutAndTheBytesOfThePoints) {
  const Cloud cloud = sample_cloud(3);
  const sensor_msgs::PointCloud2 message = test::message_of(cloud);
  EXPECT_TRUE(std::equal(message.data.begin(), message.data.end(), cloud.points_bytes.begin(),
                         cloud.points_bytes.end()));
  EXPECT_EQ(message.header.frame_id, "velodyne");
  EXPECT_EQ(message.height, 1U);
  EXPECT_EQ(message.width, 3U);
  EXPECT_EQ(message.point_step, 22U);
  EXPECT_EQ(message.row_step, 66U);
  EXPECT_TRUE(message.is_dense);
  EXPECT_FALSE(message.is_bigendian);
  const std::vector<std::tuple<std::string, unsigned, int>> expected{
      {"x", 0, 7}, {"y", 4, 7}, {"z", 8, 7}, {"intensity", 12, 7}, {"ring", 16, 4}, {"time", 18, 7}};
  ASSERT_EQ(message.fields.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(message.fields[i].name, std::get<0>(expected[i]));
    EXPECT_EQ(message.fields[i].offset, std::get<1>(expected[i]));
    EXPECT_EQ(message.fields[i].datatype, std::get<2>(expected[i]));
    EXPECT_EQ(message.fields[i].count, 1U);
  }
}

TEST(CloudToRos, TheMessageHoldsThePointsWhereTheyAreAndTheirMemoryIsUsedAgain) {
  const auto maker = row_of(test::roof_points).maker();
  Cloud cloud;
  const auto fill = [&cloud] {
    cloud = sample_cloud(100);
    cloud.points_bytes.reserve(cloud.points_bytes.size() + 1);  // a driver has room to spare
  };
  fill();
  const std::uint8_t* const points = cloud.points_bytes.data();
  std::optional<RawMessage> first = maker->make(cloud, Stamp(), ClockStep());
  EXPECT_GT(points, first->data.message_start);
  EXPECT_LT(points, first->data.message_start + first->size());
  EXPECT_NE(cloud.points_bytes.data(), points);
  fill();
  const RawMessage second = maker->make(cloud, Stamp(), ClockStep());
  EXPECT_NE(cloud.points_bytes.data(), points) << "a message that is on its way keeps its points";
  EXPECT_EQ(second.size(), first->size());
  EXPECT_EQ(std::memcmp(second.data.message_start, first->data.message_start, second.size()), 0);
  first.reset();
  fill();
  maker->make(cloud, Stamp(), ClockStep());
  EXPECT_EQ(cloud.points_bytes.data(), points);
}

TEST(CloudToRos, AFrameOfAnyLengthIsNamed) {
  Cloud cloud = sample_cloud(100);
  for (const std::size_t length : {0U, 1U, 800U, 1000U, 5000U}) {
    cloud.frame_id = std::string(length, 'f');
    const sensor_msgs::PointCloud2 message = test::message_of(cloud);
    EXPECT_EQ(message.header.frame_id, cloud.frame_id);
    ASSERT_EQ(message.data.size(), cloud.points_bytes.size());
    EXPECT_TRUE(std::equal(message.data.begin(), message.data.end(), cloud.points_bytes.begin()));
    EXPECT_TRUE(message.is_dense);
  }
}

TEST(PosesFromRos, WithoutAnOrientationAreNotRigid) {
  geometry_msgs::Quaternion turn;
  EXPECT_FALSE(is_rigid(to_pose(geometry_msgs::Vector3(), turn))) << "only the twist is filled in";
  turn.w = 0.7;
  EXPECT_TRUE(is_rigid(to_pose(geometry_msgs::Vector3(), turn)));
}

}  // namespace
}  // namespace lidard
