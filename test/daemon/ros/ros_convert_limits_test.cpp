// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Messages at the limits of what is taken: just within, just beyond, and every word of an enumeration.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "daemon/ros/ros_convert.h"
#include "daemon/ros/ros_message.h"
#include "test/support/ros_samples.h"

namespace lidard {
namespace {

using Field = sensor_msgs::PointField;
constexpr float inf = std::numeric_limits<float>::infinity();
constexpr float nan = std::numeric_limits<float>::quiet_NaN();

TEST(DiagnosticsToRos, EveryHealthHasItsLevel) {
  // diagnostic_msgs/DiagnosticStatus: OK 0, WARN 1, ERROR 2, STALE 3.
  const std::vector<DiagnosticItem> items{{"a", "", Health::ok, "", {}},
                                          {"b", "", Health::warn, "", {}},
                                          {"c", "", Health::error, "", {}},
                                          {"d", "", Health::stale, "", {}}};
  diagnostic_msgs::DiagnosticArray message;
  to_ros(items, "lidard", Stamp{3'000'000'000}, message);
  ASSERT_EQ(message.status.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(message.status[i].level, static_cast<int>(i)) << message.status[i].name;
    EXPECT_EQ(message.status[i].name, "lidard: " + items[i].name);
  }
  EXPECT_EQ(message.header.stamp, ros::Time(3, 0));
  to_ros({items[1]}, "other", Stamp{1}, message);
  ASSERT_EQ(message.status.size(), 1U) << "what was in the message before is gone";
  EXPECT_EQ(message.status[0].level, 1);
  EXPECT_EQ(message.status[0].name, "other: b");
}

TEST(DiagnosticsToRos, KeepsEveryValueInItsOrder) {
  diagnostic_msgs::DiagnosticArray message;
  to_ros({{"a", "SN", Health::ok, "m", {{"z", "1"}, {"a", "2"}, {"z", "3"}}}}, "n", Stamp{1}, message);
  ASSERT_EQ(message.status.at(0).values.size(), 3U);
  EXPECT_EQ(message.status[0].values[0].key + message.status[0].values[0].value, "z1");
  EXPECT_EQ(message.status[0].values[1].key + message.status[0].values[1].value, "a2");
  EXPECT_EQ(message.status[0].values[2].key + message.status[0].values[2].value, "z3");
}

TEST(ScanToRos, WritesEachStatusAsItsOutputWantsIt) {
  PlanarScan scan = test::sample_scan();
  scan.none_as = 41;
  scan.invalid_as = 0;
  sensor_msgs::LaserScan message;
  to_ros(scan, message);
  EXPECT_EQ(message.ranges, (std::vector<float>{1, 41, -inf, 0, 40}));
  scan.none_as = -inf;
  scan.invalid_as = inf;
  to_ros(scan, message);
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
  to_ros(scan, message);
  EXPECT_EQ(message.ranges, (std::vector<float>{1, 2, 3}));
  EXPECT_EQ(message.intensities, (std::vector<float>{100, 101, 102}));
  sensor_msgs::MultiEchoLaserScan echoes;
  to_ros(scan, echoes);
  ASSERT_EQ(echoes.ranges.size(), 3U);
  EXPECT_EQ(echoes.ranges[2].echoes, (std::vector<float>{3, 13}));
  EXPECT_EQ(echoes.intensities[1].echoes, (std::vector<float>{101, 201}));
  // A beam whose first echo is no hit has that alone; a second one that is none is left out.
  scan.set_without_hit(scan.index(1, 1), BeamStatus::none);
  to_ros(scan, echoes);
  EXPECT_EQ(echoes.ranges[1].echoes, (std::vector<float>{2}));
  EXPECT_EQ(echoes.intensities[1].echoes, (std::vector<float>{101}));
  scan.intensities.clear();
  to_ros(scan, echoes);
  EXPECT_TRUE(echoes.intensities.empty());
  EXPECT_EQ(echoes.header.frame_id, "front_laser");
  EXPECT_EQ(echoes.angle_max, 1);
  EXPECT_EQ(echoes.range_max, 40);
  EXPECT_EQ(echoes.scan_time, 0.04F);
}

const char* taken(const sensor_msgs::LaserScan& message, PlanarScan& scan) { return from_ros(message, scan); }
std::string complaint(const sensor_msgs::LaserScan& message) {
  PlanarScan scan;
  const char* why = taken(message, scan);
  return why == nullptr ? "" : why;
}
sensor_msgs::LaserScan sample_message() {
  sensor_msgs::LaserScan message;
  to_ros(test::sample_scan(), message);
  return message;
}

TEST(ScanFromRos, TakesRangesAtTheirLimitsAndInfinitiesByTheirSign) {
  auto message = sample_message();
  message.ranges = {0.1F, 40.0F, inf, -inf, nan};
  PlanarScan scan;
  ASSERT_EQ(taken(message, scan), nullptr);
  const std::vector<BeamStatus> expected{BeamStatus::hit, BeamStatus::hit, BeamStatus::none, BeamStatus::near,
                                         BeamStatus::invalid};
  EXPECT_EQ(scan.statuses, expected);
  message.ranges = {std::nextafter(0.1F, 0.0F), std::nextafter(40.0F, 50.0F), 1, 1, 1};
  ASSERT_EQ(taken(message, scan), nullptr);
  EXPECT_EQ(scan.statuses[0], BeamStatus::invalid);
  EXPECT_EQ(scan.statuses[1], BeamStatus::invalid);
  EXPECT_EQ(violation(scan), nullptr);
}

TEST(ScanFromRos, MayBeOffByOneBeamFromItsAnglesButNotByTwo) {
  for (const int off : {-2, -1, 0, 1, 2}) {
    auto message = sample_message();
    message.ranges.resize(static_cast<std::size_t>(5 + off), 1.0F);
    message.intensities.clear();
    EXPECT_EQ(complaint(message) == "", std::abs(off) <= 1) << off << ": " << complaint(message);
  }
}

TEST(ScanFromRos, OfOneBeamNeedsNoIncrement) {
  auto message = sample_message();
  message.ranges = {3};
  message.intensities.clear();
  message.angle_increment = 0;
  message.angle_max = 2;
  PlanarScan scan;
  ASSERT_EQ(taken(message, scan), nullptr);
  EXPECT_EQ(scan.beams, 1U);
  EXPECT_EQ(scan.ranges[0], 3);
  EXPECT_EQ(violation(scan), nullptr);
}

TEST(ScanFromRos, MayLastAMinuteAndNotLonger) {
  auto message = sample_message();
  message.time_increment = 12;
  EXPECT_EQ(complaint(message), "") << "five beams, 60 s";
  message.time_increment = 12.01F;
  EXPECT_EQ(complaint(message), "time_increment makes the scan longer than 60 s");
  message.time_increment = 0;
  EXPECT_EQ(complaint(message), "");
}

TEST(ScanFromRos, RangeLimitsMayBeginAtZeroAndMustDiffer) {
  auto message = sample_message();
  message.range_min = 0;
  EXPECT_EQ(complaint(message), "");
  message.range_min = message.range_max;
  EXPECT_EQ(complaint(message), "range limits are not 0 <= min < max");
  message = sample_message();
  message.angle_max = inf;
  EXPECT_EQ(complaint(message), "angles are not finite");
  message = sample_message();
  message.angle_increment = nan;
  EXPECT_EQ(complaint(message), "angles are not finite");
}

TEST(ScanFromRos, LeavesNothingOfTheMessageBefore) {
  PlanarScan scan;
  ASSERT_EQ(taken(sample_message(), scan), nullptr);
  auto message = sample_message();
  message.intensities.clear();
  message.ranges.assign(5, nan);
  message.header.frame_id = "/other";
  message.header.stamp = ros::Time(7, 0);
  message.scan_time = 0.5F;
  message.range_min = 0.2F;
  message.range_max = 30;
  ASSERT_EQ(taken(message, scan), nullptr);
  EXPECT_TRUE(scan.intensities.empty());
  EXPECT_EQ(scan.statuses, std::vector<BeamStatus>(5, BeamStatus::invalid));
  EXPECT_EQ(scan.frame_id, "other");
  EXPECT_EQ(scan.stamp.ns, 7'000'000'000);
  EXPECT_EQ(scan.scan_time, 0.5F);
  EXPECT_EQ(scan.range_min, 0.2F);
  EXPECT_EQ(scan.range_max, 30);
}

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

TEST(CloudToRos, TellsConfidenceAndEchoWhereTheyStand) {
  for (const bool confidence : {false, true}) {
    for (const bool echo : {false, true}) {
      Cloud cloud = test::sample_cloud(4);
      cloud.format.confidence = confidence;
      cloud.format.echo = echo;
      cloud.format.point_step = 22U + (confidence ? 2U : 0U) + (echo ? 1U : 0U);
      cloud.format.height = 2;
      cloud.points_bytes.resize(4 * cloud.format.point_step);
      sensor_msgs::PointCloud2 message;
      to_ros(cloud, message);
      ASSERT_EQ(message.fields.size(), 6U + (confidence ? 1U : 0U) + (echo ? 1U : 0U));
      EXPECT_EQ(message.height, 2U);
      EXPECT_EQ(message.width, 2U);
      EXPECT_EQ(message.row_step, 2 * cloud.format.point_step);
      EXPECT_EQ(message.is_dense, 0);
      if (confidence) {
        EXPECT_EQ(message.fields[6].name, "confidence");
        EXPECT_EQ(message.fields[6].offset, 22U);
        EXPECT_EQ(message.fields[6].datatype, Field::UINT16);
      }
      if (echo) {
        EXPECT_EQ(message.fields.back().name, "echo");
        EXPECT_EQ(message.fields.back().offset, confidence ? 24U : 22U);
        EXPECT_EQ(message.fields.back().datatype, Field::UINT8);
      }
    }
  }
}

TEST(CloudToRos, AMessageThatIsUsedAgainGetsTheFieldsOfItsOwnCloud) {
  sensor_msgs::PointCloud2 message;
  const auto fields_of = [&](bool confidence, bool echo) {
    Cloud cloud = test::sample_cloud(1);
    cloud.format.confidence = confidence;
    cloud.format.echo = echo;
    cloud.format.point_step = 22U + (confidence ? 2U : 0U) + (echo ? 1U : 0U);
    cloud.points_bytes.resize(cloud.format.point_step);
    to_ros(cloud, message);
    std::string names;
    for (const Field& field : message.fields) names += field.name + " ";
    return names;
  };
  const std::string plain = "x y z intensity ring time ";
  EXPECT_EQ(fields_of(true, false), plain + "confidence ");
  EXPECT_EQ(fields_of(false, true), plain + "echo ");
  EXPECT_EQ(fields_of(true, true), plain + "confidence echo ");
  EXPECT_EQ(fields_of(false, false), plain);
}

TEST(TransformsToRos, HoldARotationThatTurnsAVectorAsThePoseDoes) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-3, 3);
  for (int i = 0; i < 20; ++i) {
    const Pose pose =
        make_pose({any(random), any(random), any(random)}, {any(random), any(random), any(random)});
    tf2_msgs::TFMessage message;
    to_ros({{"base", "/laser", pose}, {"base", "other", pose}}, Stamp{5}, message);
    ASSERT_EQ(message.transforms.size(), 2U);
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
  to_ros(test::sample_imu(), message);
  to_ros(sample, message);
  EXPECT_EQ(message.orientation.w, 0.5);
  EXPECT_EQ(message.orientation.x, -0.5);
  EXPECT_EQ(message.orientation.y, 0.1);
  EXPECT_EQ(message.orientation.z, 0.7);
  EXPECT_EQ(message.orientation_covariance[0], 0) << "-1 would say that there is none";
  to_ros(test::sample_imu(), message);
  EXPECT_EQ(message.orientation.w, 0);
  EXPECT_EQ(message.orientation.z, 0);
  EXPECT_EQ(message.orientation_covariance[0], -1);
}

TEST(StateToRos, OfAMessageThatIsUsedAgainHoldsItsOwnValuesAlone) {
  diagnostic_msgs::DiagnosticArray message;
  to_ros(DeviceState{"outputs", "laser", Stamp{1}, {{"one", 1}, {"two", 2}, {"three", 3}}}, message);
  to_ros(DeviceState{"fields", "laser", Stamp{2}, {{"four", -0.5}}}, message);
  ASSERT_EQ(message.status.size(), 1U);
  EXPECT_EQ(message.status[0].name, "fields");
  ASSERT_EQ(message.status[0].values.size(), 1U);
  EXPECT_EQ(message.status[0].values[0].key, "four");
  EXPECT_EQ(message.status[0].values[0].value, "-0.5");
}

}  // namespace
}  // namespace lidard
