// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "drivers/velodyne/calibration.h"
#include "test/drivers/velodyne/calibrated_point.h"
#include "test/support/allocations.h"
#include "test/support/calibration_equations.h"

namespace lidard::velodyne {
namespace {

constexpr double tolerance_m = 1e-4;

LaserCalibration random_laser(std::mt19937& random) {
  const auto within = [&](double lowest, double highest) {
    return std::uniform_real_distribution<double>(lowest, highest)(random);
  };
  LaserCalibration laser;
  laser.rot_correction = within(-0.2, 0.2);
  laser.vert_correction = within(-0.5, 0.3);
  laser.dist_correction = within(-0.2, 1.6);
  laser.dist_correction_x = laser.dist_correction + within(-0.05, 0.05);
  laser.dist_correction_y = laser.dist_correction + within(-0.05, 0.05);
  laser.vert_offset = within(0.1, 0.22);
  laser.horiz_offset = within(-0.03, 0.03);
  laser.two_point = random() % 2 == 0 ? TwoPoint::on : TwoPoint::off;
  laser.focal_distance = within(0, 25);
  laser.focal_slope = within(0, 2);
  laser.min_intensity = static_cast<int>(random() % 50);
  laser.max_intensity = 200 + static_cast<int>(random() % 56);
  return laser;
}

void expect_near(const CalibratedPoint& point, const test::PlacedPoint& expected) {
  EXPECT_NEAR(point.x, expected.x, tolerance_m);
  EXPECT_NEAR(point.y, expected.y, tolerance_m);
  EXPECT_NEAR(point.z, expected.z, tolerance_m);
  EXPECT_NEAR(point.intensity, expected.intensity, 1e-3);
}

template <class Reference>
void compare_with(Reference reference, CalibrationModel model) {
  std::mt19937 random(3);
  for (int round = 0; round < 2000; ++round) {
    Calibration calibration;
    calibration.distance_step_m = random() % 2 == 0 ? 0.002 : 0.004;
    calibration.model = model;
    calibration.lasers = {random_laser(random), random_laser(random)};
    const CalibratedGeometry geometry(calibration);
    const auto count = static_cast<std::uint16_t>(random() % (round % 2 == 0 ? 65536 : 14000));
    const auto raw = static_cast<std::uint8_t>(random() % 256);
    const double azimuth = std::uniform_real_distribution<double>(0, 2 * M_PI)(random);
    const std::size_t id = random() % 2;
    const LaserCalibration& laser = calibration.lasers[id];
    const auto point = place(geometry, id, count, raw, std::cos(azimuth), std::sin(azimuth));
    expect_near(point, reference(laser, laser.two_point == TwoPoint::on, calibration.distance_step_m, count,
                                 raw, azimuth));
  }
}

TEST(VelodyneCalibration, RosDriversModelGivesTheEquationsOfRawdata) {
  compare_with(test::place_like_ros_drivers, CalibrationModel::ros_drivers);
}

TEST(VelodyneCalibration, ExactModelGivesTheEquationsOfTheManual) {
  compare_with(test::place_like_manual, CalibrationModel::exact);
}

TEST(VelodyneCalibration, ModelsAgreeWhereOnlyAnglesAreCorrected) {
  Calibration calibration;
  calibration.lasers.resize(1);
  calibration.lasers[0].vert_correction = -0.3;
  calibration.lasers[0].rot_correction = 0.07;
  const CalibratedGeometry exact(calibration);
  calibration.model = CalibrationModel::ros_drivers;
  const CalibratedGeometry ros_drivers(calibration);
  const auto a = place(exact, 0, 12345, 77, 0.6, 0.8);
  const auto b = place(ros_drivers, 0, 12345, 77, 0.6, 0.8);
  EXPECT_EQ(a.x, b.x);
  EXPECT_EQ(a.y, b.y);
  EXPECT_EQ(a.z, b.z);
  EXPECT_EQ(a.intensity, 77);
  EXPECT_NEAR(std::hypot(a.x, a.y, a.z), 24.69, 1e-5);
}

TEST(VelodyneCalibration, AzimuthTurnsClockwiseAndRotCorrectionIsSubtracted) {
  Calibration calibration;
  calibration.lasers.resize(1);
  const CalibratedGeometry plain(calibration);
  const auto right = place(plain, 0, 1000, 0, 0, 1);  // azimuth 90 deg
  EXPECT_NEAR(right.x, 0, 1e-7);
  EXPECT_NEAR(right.y, -2, 1e-7);
  calibration.lasers[0].rot_correction = M_PI / 2;
  const auto ahead = place(CalibratedGeometry(calibration), 0, 1000, 0, 0, 1);
  EXPECT_NEAR(ahead.x, 2, 1e-7);
  EXPECT_NEAR(ahead.y, 0, 1e-7);
}

TEST(VelodyneCalibration, UnstatedTwoPointIsUsedByTheExactModelOnly) {
  Calibration calibration;
  calibration.lasers.resize(1);
  LaserCalibration& laser = calibration.lasers[0];
  laser.dist_correction = 1.4;
  laser.dist_correction_y = 1.5;
  laser.two_point = TwoPoint::unstated;
  const auto ahead_m = [&](CalibrationModel model) {
    calibration.model = model;
    return place(CalibratedGeometry(calibration), 0, 265, 0, 1, 0).x;  // 0.53 m + 1.4 m: at the near target
  };
  EXPECT_NEAR(ahead_m(CalibrationModel::exact), 1.93, 1e-6);  // not without both near corrections
  laser.dist_correction_x = 1.5;
  EXPECT_NEAR(ahead_m(CalibrationModel::exact), 2.03, 1e-6);
  EXPECT_NEAR(ahead_m(CalibrationModel::ros_drivers), 1.93, 1e-6);
  laser.two_point = TwoPoint::on;
  EXPECT_NEAR(ahead_m(CalibrationModel::ros_drivers), 2.03, 1e-6);
  laser.two_point = TwoPoint::off;
  EXPECT_NEAR(ahead_m(CalibrationModel::exact), 1.93, 1e-6);
}

TEST(VelodyneCalibration, RosDriversKnowsOnlyTheAnglesOfAVls128) {
  Calibration calibration;
  calibration.distance_step_m = 0.004;
  calibration.model = CalibrationModel::ros_drivers;
  std::mt19937 random(5);
  for (int i = 0; i < 128; ++i) calibration.lasers.push_back(random_laser(random));
  const CalibratedGeometry geometry(calibration);
  EXPECT_EQ(geometry.distance(9, 1000), 4.0);
  const auto point = place(geometry, 9, 1000, 250, 1, 0);
  EXPECT_NEAR(point.z, 4 * std::sin(calibration.lasers[9].vert_correction), 1e-6);
  EXPECT_EQ(point.intensity, 250);
}

TEST(VelodyneCalibration, RingsAscendAndTiesKeepTheOrderOfTheLasers) {
  Calibration calibration;
  for (const double elevation : {0.1, -0.2, 0.1, 0.0}) {
    calibration.lasers.emplace_back();
    calibration.lasers.back().vert_correction = elevation;
  }
  EXPECT_EQ(rings_by_elevation(calibration), (std::vector<std::uint16_t>{2, 0, 3, 1}));
}

TEST(VelodyneCalibration, PlacingAllocatesNothing) {
  Calibration calibration;
  calibration.lasers.resize(64);
  const CalibratedGeometry geometry(calibration);
  const std::uint64_t before = test::allocations();
  float sum = 0;
  for (std::size_t i = 0; i < 64; ++i) sum += place(geometry, i, 500, 1, 1, 0).x;
  EXPECT_EQ(test::allocations(), before);
  EXPECT_NEAR(sum, 64, 1e-3);
}

}  // namespace
}  // namespace lidard::velodyne
