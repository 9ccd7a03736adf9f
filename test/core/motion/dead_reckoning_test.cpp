// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/motion/dead_reckoning.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace lidard {
namespace {

constexpr Stamp begin{1'700'000'000'000'000'000};
constexpr Span step = std::chrono::milliseconds(10);

TEST(DeadReckoning, DrivesTheCircleOfItsSpeedAndTurnRate) {
  DeadReckoning reckoning;
  PoseTrack track;
  reckoning.speed(2);
  const double rate = 0.5;
  for (int i = 0; i <= 100; ++i) reckoning.turn(begin + i * step, {0, 0, rate}, track);
  Pose pose;
  ASSERT_EQ(track.at(begin + 100 * step, pose), PoseOrigin::known);
  // Radius 4 m, half a radian along it.
  EXPECT_NEAR(pose.translation().x(), 4 * std::sin(0.5), 1e-4);
  EXPECT_NEAR(pose.translation().y(), 4 * (1 - std::cos(0.5)), 1e-4);
  EXPECT_NEAR(std::atan2(pose.linear()(1, 0), pose.linear()(0, 0)), 0.5, 1e-9);
}

TEST(DeadReckoning, CountsWhatItCannotUse) {
  DeadReckoning reckoning;
  PoseTrack track;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  reckoning.speed(nan);
  reckoning.turn(begin, {0, nan, 0}, track);
  reckoning.turn(begin, {0, 0, 0}, track);
  reckoning.turn(begin, {0, 0, 0}, track);
  EXPECT_EQ(reckoning.refused(), 3U);
  EXPECT_EQ(track.size(), 1U);
}

TEST(DeadReckoning, DoesNotDriveThroughAPause) {
  DeadReckoning reckoning;
  PoseTrack track;
  reckoning.speed(3);
  reckoning.turn(begin, {0, 0, 1}, track);
  reckoning.turn(begin + std::chrono::seconds(5), {0, 0, 1}, track);
  Pose pose;
  ASSERT_EQ(track.at(begin + std::chrono::seconds(5), pose), PoseOrigin::known);
  EXPECT_TRUE(pose.isApprox(Pose::Identity()));
}

}  // namespace
}  // namespace lidard
