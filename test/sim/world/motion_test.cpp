// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/world/motion.h"

#include <gtest/gtest.h>

#include <cmath>

#include "test/sim/world/rng.h"

namespace {

using namespace lidard::sim;

TEST(Trajectory, QuarterCircleEndsBesideItsCentre) {
  // 2 m/s at 0.5 rad/s: a circle of radius 4 m.
  const Pose2 end = drive({1, 2, 0}, {100, 2, 0.5}, lidard::pi_d / 2 / 0.5);
  EXPECT_NEAR(end.x, 1 + 4, 1e-12);
  EXPECT_NEAR(end.y, 2 + 4, 1e-12);
  EXPECT_NEAR(end.yaw, lidard::pi_d / 2, 1e-12);
}

TEST(Trajectory, TinyYawRateIsNearlyAStraightLine) {
  const Pose2 arc = drive({0, 0, 0.3}, {100, 2, 1e-12}, 10);
  const Pose2 line = drive({0, 0, 0.3}, {100, 2, 0}, 10);
  EXPECT_NEAR(arc.x, line.x, 1e-9);
  EXPECT_NEAR(arc.y, line.y, 1e-9);
}

TEST(Trajectory, AgreesWithNumericIntegrationOverSeveralLegs) {
  const Trajectory path({-8, -5, 0.2}, {{0.7, 1.5, 0.1}, {0.5, 3, -0.8}, {1, -1, 0.4}});
  const double step = 1e-5;
  Pose2 place{-8, -5, 0.2};
  double yaw_rate = 0;
  for (int i = 0; i < 220000; ++i) {
    const double middle = (i + 0.5) * step;
    yaw_rate = middle < 0.7 ? 0.1 : middle < 1.2 ? -0.8 : 0.4;
    const double speed = path.speed(middle);
    place.x += speed * step * std::cos(place.yaw + yaw_rate * step / 2);
    place.y += speed * step * std::sin(place.yaw + yaw_rate * step / 2);
    place.yaw += yaw_rate * step;
  }
  const Pose2 exact = path.at(2.2);
  EXPECT_NEAR(place.x, exact.x, 1e-9);
  EXPECT_NEAR(place.y, exact.y, 1e-9);
  EXPECT_NEAR(place.yaw, exact.yaw, 1e-9);
}

TEST(Trajectory, StandsStillBeforeTheStartAndAfterTheEnd) {
  const Trajectory path({1, 1, 0}, {{2, 1, 0}});
  EXPECT_EQ(path.at(-5).x, 1);
  EXPECT_EQ(path.at(7).x, 3);
  EXPECT_EQ(path.speed(-1), 0);
  EXPECT_EQ(path.speed(1), 1);
  EXPECT_EQ(path.speed(2), 0);
  EXPECT_EQ(Trajectory().at(3).x, 0);
}

TEST(Rng, GivesThePublishedNumbersOfSplitMix64) {
  Rng rng(1234567);
  EXPECT_EQ(rng.bits(), 6457827717110365317U);
  EXPECT_EQ(rng.bits(), 3203168211198807973U);
}

TEST(Rng, GaussianHasMeanZeroAndDeviationOne) {
  Rng rng(5);
  double sum = 0;
  double squares = 0;
  constexpr int n = 100000;
  for (int i = 0; i < n; ++i) {
    const double value = rng.gaussian();
    sum += value;
    squares += value * value;
  }
  EXPECT_NEAR(sum / n, 0, 0.02);
  EXPECT_NEAR(squares / n, 1, 0.02);
}

}  // namespace
