// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/motion/pose_track.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "test/sim/world/motion.h"
#include "test/sim/world/units.h"
#include "test/support/allocations.h"

namespace lidard {
namespace {

/// Knots every 20 ms on an arc, from t0 on.
PoseTrack arc_track(double speed, double yaw_rate, int knots) {
  PoseTrack track;
  for (int i = 0; i < knots; ++i)
    track.add(t0 + ms(20 * i), sim::to_pose(sim::drive({}, {10, speed, yaw_rate}, 0.02 * i)));
  return track;
}

double distance(const Pose& a, const Pose& b) { return (a.translation() - b.translation()).norm(); }

TEST(PoseTrack, GivesBackItsKnotsAndWhatLiesBetween) {
  const PoseTrack track = arc_track(2, 1, 11);
  EXPECT_EQ(track.oldest(), t0);
  EXPECT_EQ(track.newest(), t0 + ms(200));
  for (double t = 0; t <= 200; t += 1) {
    Pose pose;
    ASSERT_EQ(track.at(t0 + ms(t), pose), PoseOrigin::known);
    const Pose truth = sim::to_pose(sim::drive({}, {10, 2, 1}, t * 1e-3));
    // Between two knots the arc is a chord.
    EXPECT_LT(distance(pose, truth), 2 * 1 * 0.02 * 0.02 / 8 + 1e-9) << t;
    EXPECT_TRUE(pose.linear().isApprox(truth.linear(), 1e-9)) << t;
    EXPECT_TRUE(is_rigid(pose));
  }
}

TEST(PoseTrack, BeforeTheOldestKnotAndWhenEmptyNothingIsKnown) {
  Pose pose = make_pose({1, 2, 3}, {0, 0, 0});
  EXPECT_EQ(PoseTrack().at(t0, pose), PoseOrigin::missing);
  EXPECT_EQ(arc_track(1, 1, 5).at(t0 - Span(1), pose), PoseOrigin::missing);
  EXPECT_EQ(pose.translation().x(), 1);  // left alone
}

TEST(PoseTrack, ClimbingAndRollingTwistsAreCarriedOnToo) {
  const Pose step = make_pose({0.04, 0.01, 0.005}, {0.02, -0.01, 0.03});
  PoseTrack track;
  Pose pose = make_pose({3, -2, 1}, {0.3, 0.2, 2});
  for (int i = 0; i < 4; ++i, pose = pose * step) track.add(t0 + ms(20 * i), pose);
  Pose ahead;
  ASSERT_EQ(track.at(t0 + ms(80), ahead), PoseOrigin::extrapolated);
  EXPECT_TRUE(ahead.matrix().isApprox(pose.matrix(), 1e-9));
}

TEST(PoseTrack, TwistIsNotTakenFromKnotsThatAreNearlyAtOneTime) {
  PoseTrack track;
  track.add(t0, make_pose({0, 0, 0}, {0, 0, 0}));
  track.add(t0 + ms(20), make_pose({0.02, 0, 0}, {0, 0, 0}));
  track.add(t0 + ms(20.1), make_pose({0.03, 0, 0}, {0, 0, 0}));  // 10 mm of noise in 0.1 ms
  Pose pose;
  ASSERT_EQ(track.at(t0 + ms(60), pose), PoseOrigin::extrapolated);
  EXPECT_LT(pose.translation().x(), 0.1);
}

TEST(PoseTrack, OneKnotAloneTellsOnlyItsOwnMoment) {
  const PoseTrack track = arc_track(1, 0, 1);
  Pose pose;
  EXPECT_EQ(track.at(t0, pose), PoseOrigin::known);
  EXPECT_EQ(track.at(t0 + Span(1), pose), PoseOrigin::missing);
}

TEST(PoseTrack, DoesNotGuessAcrossAGap) {
  PoseTrack track;
  for (const int t : {0, 20, 280, 300}) track.add(t0 + ms(t), make_pose({t * 1e-3, 0, 0}, {0, 0, 0}));
  Pose pose;
  EXPECT_EQ(track.at(t0 + ms(21), pose), PoseOrigin::missing);
  EXPECT_EQ(track.at(t0 + ms(279), pose), PoseOrigin::missing);
  EXPECT_EQ(track.at(t0 + ms(280), pose), PoseOrigin::known);
  EXPECT_TRUE(track.covers(t0 + ms(5), t0 + ms(20)));
  EXPECT_FALSE(track.covers(t0 + ms(5), t0 + ms(290)));
  EXPECT_TRUE(track.covers(t0 + ms(285), t0 + ms(340)));
  EXPECT_FALSE(track.covers(t0 + ms(285), t0 + ms(351)));
  // A knot of 250 ms later stands exactly at the limit.
  track.add(t0 + ms(550), make_pose({0.55, 0, 0}, {0, 0, 0}));
  EXPECT_TRUE(track.covers(t0 + ms(290), t0 + ms(540)));
}

TEST(PoseTrack, StandingVehicleStaysInPlaceToTheLastBit) {
  const Pose place = make_pose({123.456, -7.89, 0.1}, {0.01, 0.02, 2.3});
  PoseTrack track;
  for (int i = 0; i < 5; ++i) track.add(t0 + ms(20 * i), place);
  Pose first, other;
  track.at(t0, first);
  for (const double t : {1.0, 20.0, 33.3, 79.9, 95.0, 130.0}) {
    ASSERT_NE(track.at(t0 + ms(t), other), PoseOrigin::missing);
    EXPECT_EQ(first.matrix(), other.matrix()) << t;
  }
}

TEST(PoseTrack, JumpBackBeginsAnewAndSmallerOnesAreIgnored) {
  PoseTrack track = arc_track(1, 0, 10);
  EXPECT_FALSE(track.add(t0 + ms(180), Pose::Identity()));
  EXPECT_FALSE(track.add(t0 + ms(100), Pose::Identity()));
  EXPECT_EQ(track.out_of_order(), 2U);
  EXPECT_EQ(track.size(), 10U);
  EXPECT_EQ(track.restarts(), 0U);
  EXPECT_TRUE(track.add(t0 - std::chrono::seconds(10), Pose::Identity()));
  EXPECT_EQ(track.restarts(), 1U);
  EXPECT_EQ(track.size(), 1U);
  EXPECT_EQ(track.newest(), t0 - std::chrono::seconds(10));
}

TEST(PoseTrack, RefusesWhatIsNoRigidPose) {
  PoseTrack track = arc_track(1, 0, 2);
  Pose bad = Pose::Identity();
  bad.translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(track.add(t0 + ms(60), bad));
  bad = Pose::Identity();
  bad.linear() *= 1.1;
  EXPECT_FALSE(track.add(t0 + ms(60), bad));
  bad.linear() = Eigen::Vector3d(1, 1, -1).asDiagonal();
  EXPECT_FALSE(track.add(t0 + ms(60), bad));
  EXPECT_EQ(track.not_rigid(), 3U);
  EXPECT_EQ(track.newest(), t0 + ms(20));
}

TEST(PoseTrack, KeepsTheNewestInFixedMemory) {
  PoseTrackSettings settings;
  settings.knots = 16;
  PoseTrack track(settings);
  const std::uint64_t before = test::allocations();
  for (int i = 0; i < 1000; ++i) track.add(t0 + ms(20 * i), make_pose({0.02 * i, 0, 0}, {0, 0, 0}));
  Pose pose;
  for (int i = 984; i < 999; ++i) {
    ASSERT_EQ(track.at(t0 + ms(20 * i + 10), pose), PoseOrigin::known);
    EXPECT_NEAR(pose.translation().x(), 0.02 * i + 0.01, 1e-9);
  }
  EXPECT_EQ(test::allocations(), before);
  EXPECT_EQ(track.size(), 16U);
  EXPECT_EQ(track.at(t0 + ms(20 * 983), pose), PoseOrigin::missing);
}

TEST(PoseTrack, TurnsTheShortWayThroughHalfATurn) {
  PoseTrack track;
  track.add(t0, make_pose({0, 0, 0}, {0, 0, 3.1}));
  track.add(t0 + ms(20), make_pose({0, 0, 0}, {0, 0, -3.1}));
  Pose pose;
  ASSERT_EQ(track.at(t0 + ms(10), pose), PoseOrigin::known);
  EXPECT_NEAR(pose.linear()(0, 0), -1, 1e-9);
  ASSERT_EQ(track.at(t0 + ms(30), pose), PoseOrigin::extrapolated);
  const double half_step = (2 * pi_d - 6.2) / 2;
  EXPECT_NEAR(std::atan2(pose.linear()(1, 0), pose.linear()(0, 0)), -3.1 + half_step, 1e-9);
}

}  // namespace
}  // namespace lidard
