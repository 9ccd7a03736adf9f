// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/motion/pose_track.h"

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

TEST(DeadReckoning, ATurnRateThatRisesIsIntegratedWithoutLag) {
  // 0 to 1 rad/s in a second: half a radian, whatever the steps.
  for (const int steps : {5, 20, 100}) {
    DeadReckoning reckoning;
    PoseTrack track;
    const Span each = Span(std::chrono::seconds(1)) / steps;
    for (int i = 0; i <= steps; ++i) reckoning.turn(begin + i * each, {0, 0, 1.0 * i / steps}, track);
    Pose pose;
    ASSERT_EQ(track.at(begin + steps * each, pose), PoseOrigin::known);
    EXPECT_NEAR(std::atan2(pose.linear()(1, 0), pose.linear()(0, 0)), 0.5, 1e-9) << steps;
    EXPECT_TRUE(pose.translation().isZero()) << "it did not drive";
  }
}

TEST(DeadReckoning, DrivesAheadAndBackAsTheSpeedSays) {
  DeadReckoning reckoning;
  PoseTrack track;
  for (int i = 0; i <= 300; ++i) {
    if (i == 1) reckoning.speed(2);
    if (i == 201) reckoning.speed(-1);
    reckoning.turn(begin + i * step, {0, 0, 0}, track);
  }
  Pose pose;
  ASSERT_EQ(track.at(begin + 200 * step, pose), PoseOrigin::known);
  EXPECT_NEAR(pose.translation().x(), 4, 1e-9);
  ASSERT_EQ(track.at(begin + 300 * step, pose), PoseOrigin::known);
  EXPECT_NEAR(pose.translation().x(), 3, 1e-9);
}

TEST(DeadReckoning, TurnsAboutAnyAxisOfTheVehicle) {
  const Eigen::Vector3d axis = Eigen::Vector3d(1, -2, 0.5).normalized();
  DeadReckoning reckoning;
  PoseTrack track;
  for (int i = 0; i <= 100; ++i) reckoning.turn(begin + i * step, 0.7 * axis, track);
  Pose pose;
  ASSERT_EQ(track.at(begin + 100 * step, pose), PoseOrigin::known);
  EXPECT_TRUE(pose.linear().isApprox(Eigen::AngleAxisd(0.7, axis).toRotationMatrix(), 1e-9));
}

TEST(DeadReckoning, AGapOfASecondIsBridgedAndALongerOneOrAJumpBackKeepsThePlace) {
  const auto x_after = [](Span gap) {
    DeadReckoning reckoning;
    PoseTrackSettings settings;
    settings.max_pose_gap = std::chrono::seconds(2);
    PoseTrack track(settings);
    reckoning.speed(3);
    reckoning.turn(begin, {0, 0, 0}, track);
    reckoning.turn(begin + step, {0, 0, 0}, track);
    reckoning.turn(begin + step + gap, {0, 0, 0}, track);
    EXPECT_EQ(reckoning.refused(), 0U);
    Pose pose;
    EXPECT_EQ(track.at(begin + step + gap, pose), PoseOrigin::known);
    return pose.translation().x();
  };
  using std::chrono::seconds;
  EXPECT_NEAR(x_after(seconds(1)), 3.03, 1e-9);
  EXPECT_NEAR(x_after(seconds(1) + Span(1)), 0.03, 1e-9);
  EXPECT_NEAR(x_after(-seconds(1) - Span(1)), 0.03, 1e-9);
}

TEST(DeadReckoning, AStampALittleBackIsRefusedAndDoesNoHarm) {
  DeadReckoning reckoning;
  PoseTrack track;
  reckoning.speed(1);
  reckoning.turn(begin, {0, 0, 0}, track);
  reckoning.turn(begin + 2 * step, {0, 0, 0}, track);
  reckoning.turn(begin + step, {0, 0, 5}, track);
  reckoning.turn(begin - std::chrono::seconds(1) + 2 * step, {0, 0, 5}, track);
  EXPECT_EQ(reckoning.refused(), 2U);
  reckoning.turn(begin + 3 * step, {0, 0, 0}, track);
  Pose pose;
  ASSERT_EQ(track.at(begin + 3 * step, pose), PoseOrigin::known);
  EXPECT_TRUE(pose.isApprox(make_pose({0.03, 0, 0}, {0, 0, 0}), 1e-12));
}

}  // namespace
}  // namespace lidard
