// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/mounts/ground.h"

#include <gtest/gtest.h>

#include <random>

#include "core/base/angle.h"

namespace lidard {
namespace {

/// Returns of rings from `lowest` degrees upwards in steps of `step` on flat ground and walls around it, in
/// the frame of the sensor.
std::vector<Eigen::Vector3d> returns_at(const Pose& base_from_sensor, double lowest = -15, double step = 2,
                                        int rings = 16) {
  std::vector<Eigen::Vector3d> points;
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 0.01);
  for (int ring = 0; ring < rings; ++ring) {
    for (int i = 0; i < 720; ++i) {
      const double up = (lowest + step * ring) * rad_per_deg, azimuth = two_pi * i / 720;
      const Eigen::Vector3d ray(std::cos(up) * std::cos(azimuth), std::cos(up) * std::sin(azimuth),
                                std::sin(up));
      const Eigen::Vector3d along = base_from_sensor.linear() * ray, from = base_from_sensor.translation();
      double range = along.z() < 0 ? -from.z() / along.z() : 1e9;
      range = std::min(range, ((along.x() > 0 ? 6 : -20) - from.x()) / along.x());
      range = std::min(range, ((along.y() > 0 ? 18 : -16) - from.y()) / along.y());
      if (range < 60) points.emplace_back(ray * (range + noise(random)));
    }
  }
  return points;
}

TEST(Ground, GivesHeightRollAndPitchWhereThePoseIsConfiguredWrong) {
  const Pose truth = make_pose({0.2, 0, 2.04}, {0.8 * rad_per_deg, -1.2 * rad_per_deg, 0.5});
  const Pose configured = make_pose({0, 0, 1.7}, {8 * rad_per_deg, 5 * rad_per_deg, 0.2});
  const auto ground = find_ground(returns_at(truth), configured);
  ASSERT_TRUE(ground);
  EXPECT_NEAR(ground->height, 2.04, 0.003);
  const Eigen::Vector3d up = truth.linear().transpose() * Eigen::Vector3d::UnitZ();
  EXPECT_LT(std::acos(std::min(1.0, up.dot(ground->up))), 0.02 * rad_per_deg);
}

TEST(Ground, IsFoundBeneathALidarThatHangsUpsideDown) {
  const Pose truth = make_pose({0.2, 0, 2.04}, {pi_d + 0.02, -0.01, 0.5});
  const auto ground = find_ground(returns_at(truth), make_pose({0, 0, 1.7}, {pi_d, 0, 0.2}));
  ASSERT_TRUE(ground);
  EXPECT_NEAR(ground->height, 2.04, 0.003);
  EXPECT_LT((tilt_to(ground->up) - tilt_of(truth.linear())).norm(), 1e-3);
}

TEST(Ground, IsNotFoundWhereLowRingsMeetWallsAlone) {
  // As of an HDL-64E upside down, whose ground begins beyond the walls.
  const auto level = returns_at(make_pose({0.2, 0, 2.04}, {0.014, -0.02, 0.5}), -4, 0.4, 20);
  EXPECT_FALSE(find_ground(level, make_pose({0, 0, 1.8}, {0, 0, 0})));
}

TEST(Ground, IsNotFoundWhereOnlyWallsAreSeen) {
  std::vector<Eigen::Vector3d> wall;
  for (int i = 0; i < 5000; ++i) wall.emplace_back(5, 0.01 * (i % 100), 0.05 * (i / 100) - 2);
  EXPECT_FALSE(find_ground(wall, make_pose({0, 0, 2}, {0, 0, 0})));
}

TEST(Ground, TiltAndYawMakeTheRotation) {
  const Eigen::Matrix3d rotation = make_pose({0, 0, 0}, {0.1, -0.2, 2.5}).linear();
  const Eigen::Matrix3d again =
      Eigen::AngleAxisd(yaw_of(rotation), Eigen::Vector3d::UnitZ()).toRotationMatrix() * tilt_of(rotation);
  EXPECT_LT((again - rotation).norm(), 1e-12);
  const Eigen::Vector3d up = rotation.transpose() * Eigen::Vector3d::UnitZ();
  EXPECT_LT((tilt_to(up) - tilt_of(rotation)).norm(), 1e-9);
}

}  // namespace
}  // namespace lidard
