// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/motion/pose_track.h"
#include "test/sim/world/rng.h"
#include "test/sim/world/units.h"
#include "test/sim/world/vehicle_motion.h"

namespace lidard {
namespace {

double yaw_of(const Pose& pose) { return std::atan2(pose.linear()(1, 0), pose.linear()(0, 0)); }

/// What a vehicle that accelerates steadily, from a given speed and turn rate on, has done after `t` s.
struct Accelerating {
  double speed, acceleration;  // m/s, m/s2; along x
  double rate, turn;           // rad/s, rad/s2
  Pose at(double t) const {
    return make_pose({speed * t + acceleration * t * t / 2, 0, 0}, {0, 0, rate * t + turn * t * t / 2});
  }
};

PoseTrack track_of(const Accelerating& vehicle, const std::vector<double>& knots_ms) {
  PoseTrack track;
  for (const double t : knots_ms) track.add(t0 + ms(t), vehicle.at(t * 1e-3));
  return track;
}

TEST(PoseTrackMotion, ASteadyAccelerationIsCarriedOnBeyondTheNewestPose) {
  for (const Accelerating& vehicle : {Accelerating{1, 3, 0, 0}, Accelerating{2, -4, 0, 0},
                                      Accelerating{0, 0, 0.5, 2}, Accelerating{0, 0, 1, -3}}) {
    for (const std::vector<double>& knots :
         {std::vector<double>{0, 20, 40}, {0, 30, 50}, {0, 20, 49}, {0, 10, 20, 30}, {0, 12, 24}}) {
      const PoseTrack track = track_of(vehicle, knots);
      for (const double ahead : {5.0, 20.0, 49.0}) {
        Pose pose;
        ASSERT_EQ(track.at(t0 + ms(knots.back() + ahead), pose), PoseOrigin::extrapolated);
        const Pose truth = vehicle.at((knots.back() + ahead) * 1e-3);
        EXPECT_NEAR(pose.translation().x(), truth.translation().x(), 1e-9) << knots.back() << " + " << ahead;
        EXPECT_NEAR(yaw_of(pose), yaw_of(truth), 1e-9) << knots.back() << " + " << ahead;
      }
    }
  }
}

TEST(PoseTrackMotion, OneStretchAloneOrOneOfAnotherLengthTellsASteadyTwist) {
  const Accelerating vehicle{1, 3, 0, 0};
  // Mean speed of the last stretch, carried on: what half the stretch and the time ahead gained is missing.
  const auto steady = [&](double before, double last, double ahead) {
    const double speed = vehicle.speed + vehicle.acceleration * (before + last) / 2;
    return vehicle.at(last).translation().x() + speed * ahead;
  };
  const struct {
    std::vector<double> knots;
    bool is_steady;
  } cases[] = {
      {{0, 20}, true}, {{0, 20, 61}, true}, {{0, 41, 61}, true}, {{0, 20, 59}, false}, {{0, 39, 59}, false}};
  for (const auto& each : cases) {
    const PoseTrack track = track_of(vehicle, each.knots);
    Pose pose;
    const double last = each.knots.back(), before = each.knots[each.knots.size() - 2];
    ASSERT_EQ(track.at(t0 + ms(last + 40), pose), PoseOrigin::extrapolated);
    const double expected = each.is_steady ? steady(before * 1e-3, last * 1e-3, 0.04)
                                           : vehicle.at((last + 40) * 1e-3).translation().x();
    EXPECT_NEAR(pose.translation().x(), expected, 1e-9) << before << ", " << last;
  }
}

TEST(PoseTrackMotion, ASwingingVehicleIsFollowedToTwoMillimetresOverTheNextPeriod) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const sim::SwingingVehicle vehicle(seed, 2);
    PoseTrack track;
    vehicle.report(track, t0, 50, 0.5, 1);
    for (double ahead = 1; ahead <= 20; ahead += 1) {
      Pose pose;
      const double newest = seconds(track.newest() - t0);
      ASSERT_EQ(track.at(track.newest() + ms(ahead), pose), PoseOrigin::extrapolated);
      const Pose truth = sim::to_pose(vehicle.at(newest + ahead * 1e-3));
      // At 10 m; with a steady twist it would be up to 4 mm.
      const Eigen::Vector3d off = pose * Eigen::Vector3d(10, 0, 0) - truth * Eigen::Vector3d(10, 0, 0);
      EXPECT_LT(off.norm(), 2e-3) << seed << ' ' << ahead;
    }
  }
}

TEST(PoseTrackMotion, BetweenTwoKnotsTheWayIsStraightAndTheTurnSteadyWhateverThePoses) {
  sim::Rng rng(5);
  const auto draw = [&rng](double reach) { return reach * (2 * rng.uniform() - 1); };
  for (int round = 0; round < 100; ++round) {
    const Pose a = make_pose({draw(9), draw(9), draw(2)}, {draw(1), draw(1), draw(3)});
    const Eigen::Vector3d axis = Eigen::Vector3d(draw(1), draw(1), draw(1)).normalized();
    const double angle = draw(0.5);
    Pose b = a * Pose(Eigen::AngleAxisd(angle, axis));
    b.translation() = a.translation() + Eigen::Vector3d(draw(0.2), draw(0.2), draw(0.2));
    PoseTrack track;
    track.add(t0, a);
    track.add(t0 + ms(80), b);
    const double share = rng.uniform();
    Pose pose;
    ASSERT_EQ(track.at(t0 + ms(80 * share), pose), PoseOrigin::known);
    Pose truth = a * Pose(Eigen::AngleAxisd(angle * share, axis));
    truth.translation() = a.translation() + share * (b.translation() - a.translation());
    EXPECT_LT((pose.matrix() - truth.matrix()).norm(), 1e-7) << round;
  }
}

TEST(PoseTrackMotion, CoversWhatEveryMomentInBetweenHasAPoseFor) {
  sim::Rng rng(7);
  int covered = 0, gaps = 0;
  for (int round = 0; round < 300; ++round) {
    PoseTrack track;
    double t = 0;
    std::vector<double> knots;
    for (int i = 0; i < 8; ++i) {
      knots.push_back(t);
      track.add(t0 + ms(t), make_pose({t, 0, 0}, {0, 0, 0}));
      t += rng.uniform() < 0.2 ? 260 + 100 * rng.uniform() : 20 + 225 * rng.uniform();
    }
    double first = std::round(rng.uniform() * t * 1.1 - t * 0.05),
           last = first + std::round(rng.uniform() * t / 2);
    // Some begin or end exactly at a knot.
    if (round % 3 == 0) first = knots[static_cast<std::size_t>(round) % 5];
    last = std::max(first, last);
    bool every = true;
    Pose pose;
    for (double at = first; at <= last; at += 1)
      every = every && track.at(t0 + ms(at), pose) != PoseOrigin::missing;
    every = every && track.at(t0 + ms(last), pose) != PoseOrigin::missing;
    ASSERT_EQ(track.covers(t0 + ms(first), t0 + ms(last)), every) << round << ": " << first << " to " << last;
    ++(every ? covered : gaps);
  }
  EXPECT_GT(covered, 50);
  EXPECT_GT(gaps, 50);
}

TEST(PoseTrackMotion, LimitsHoldAtTheirEdges) {
  PoseTrack track;
  track.add(t0, Pose::Identity());
  track.add(t0 + ms(250), make_pose({0.25, 0, 0}, {0, 0, 0}));
  Pose pose;
  EXPECT_EQ(track.at(t0 + ms(125), pose), PoseOrigin::known);
  EXPECT_EQ(track.at(t0 + ms(300), pose), PoseOrigin::extrapolated);
  EXPECT_NEAR(pose.translation().x(), 0.3, 1e-9);
  EXPECT_EQ(track.at(t0 + ms(300) + Span(1), pose), PoseOrigin::missing);
  track.clear();
  EXPECT_TRUE(track.empty());
  EXPECT_EQ(track.newest(), Stamp{});
  track.add(t0, Pose::Identity());
  track.add(t0 + ms(250) + Span(1), make_pose({0.25, 0, 0}, {0, 0, 0}));
  EXPECT_EQ(track.at(t0 + ms(125), pose), PoseOrigin::missing);
  EXPECT_EQ(track.at(t0 + ms(260), pose), PoseOrigin::missing) << "no motion is known across a gap";
  // A second back is late, more begins anew.
  EXPECT_FALSE(track.add(track.newest() - std::chrono::seconds(1), Pose::Identity()));
  EXPECT_EQ(track.restarts(), 0U);
  EXPECT_TRUE(track.add(track.newest() - std::chrono::seconds(1) - Span(1), Pose::Identity()));
  EXPECT_EQ(track.restarts(), 1U);
}

TEST(PoseTrackMotion, TenMillisecondsAreLongEnoughToTellAMotion) {
  PoseTrack track;
  track.add(t0, make_pose({0, 0, 0}, {0, 0, 0}));
  track.add(t0 + ms(100), make_pose({0, 0, 0}, {0, 0, 0}));
  track.add(t0 + ms(110), make_pose({0.01, 0, 0}, {0, 0, 0}));
  Pose pose;
  ASSERT_EQ(track.at(t0 + ms(120), pose), PoseOrigin::extrapolated);
  EXPECT_NEAR(pose.translation().x(), 0.02, 1e-9) << "1 m/s";
  PoseTrack shorter;
  shorter.add(t0, make_pose({0, 0, 0}, {0, 0, 0}));
  shorter.add(t0 + ms(100.1), make_pose({0, 0, 0}, {0, 0, 0}));
  shorter.add(t0 + ms(110), make_pose({0.011, 0, 0}, {0, 0, 0}));
  ASSERT_EQ(shorter.at(t0 + ms(120), pose), PoseOrigin::extrapolated);
  EXPECT_NEAR(pose.translation().x(), 0.012, 1e-9) << "0.1 m/s over all of it";
}

}  // namespace
}  // namespace lidard
