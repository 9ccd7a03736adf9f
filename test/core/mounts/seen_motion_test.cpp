// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/mounts/seen_motion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "core/base/angle.h"
#include "test/sim/world/flat_world.h"

namespace lidard {
namespace {

using Eigen::Vector2d;
using sim::FlatWorld;

/// What moves in a yard, by time in s.
using Passers = std::function<void(FlatWorld& world, double time)>;

/// A yard around a vehicle, and what a scanner of it sees in 12 s, in which the vehicle drives as `legs` say.
struct WatchedVehicle {
  explicit WatchedVehicle(unsigned seed) : random(seed) {
    yard.add_box({0, 0}, {random.within(4) + 14, random.within(3) + 11}, random.within(0.3));
    for (int i = 0; i < 10; ++i) {
      const Vector2d centre(random.within(13), random.within(10));
      if (centre.norm() > 5)
        yard.add_box(centre, {0.8 + random.within(0.6), 0.8 + random.within(0.6)}, random.within(1.5));
    }
  }
  std::optional<SeenMotion> look(const std::vector<sim::Twist>& legs, const Passers& passers) {
    const sim::Trajectory path({0, 0, 0.3}, legs);
    sim::FlatScanner scanner;
    scanner.at = {0.5, 0.6}, scanner.yaw = 0.6, scanner.increment = 0.5 * rad_per_deg;
    scanner.noise = 0.015, scanner.range_max = 30;
    std::vector<DriveSweep> sweeps;
    PlanarScan scan;
    for (double t = 0; t < 12; t += keyframe_s) {
      FlatWorld world = yard;
      passers(world, t);
      scanner.measure(
          world, [&](std::size_t) { return path.at(t); }, random, scan);
      DriveSweep sweep{t, scanner.increment, {}};
      for (std::size_t i = 0; i < scan.beams; ++i) {
        const float angle = scan.angle(i), range = scan.ranges[i];
        if (scan.statuses[i] == BeamStatus::hit)
          sweep.returns.push_back({{range * std::cos(angle), range * std::sin(angle), 0}, 0, 0});
      }
      sweeps.push_back(sweep);
    }
    return find_motion(sweeps, Eigen::Matrix3d::Identity(), {0.5, 0.6, 0.6}, -1e9);
  }
  sim::Rng random;
  FlatWorld yard;
};

void nobody(FlatWorld& /*world*/, double /*time*/) {}

/// Five people who walk round the vehicle and one who leans on it.
void people(FlatWorld& world, double time) {
  for (int i = 0; i < 5; ++i) {
    const double at = 1.3 * i + (i % 2 == 0 ? 0.5 : -0.4) * time, far = 2.2 + 0.5 * i;
    for (const double leg : {-0.15, 0.15})
      world.add_box({far * std::cos(at) + leg, far * std::sin(at)}, {0.08, 0.08}, at);
  }
  world.add_box({1.2, 1.4}, {0.25, 0.15}, 0.2 * time);
}

/// A lorry that passes at 2 m/s, and one that comes and stops.
void lorries(FlatWorld& world, double time) {
  world.add_box({-13 + 2 * time, 4.5}, {4, 1.2}, 0);
  world.add_box({-12 + std::min(time, 7.0), -4.5}, {4, 1.2}, 0);
}

TEST(SeenMotion, AVehicleThatStandsStandsWhoeverPasses) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    for (const Passers& passers : {Passers(nobody), Passers(people), Passers(lorries)}) {
      const auto motion = WatchedVehicle(seed).look({{20, 0, 0}}, passers);
      EXPECT_FALSE(motion) << seed << ": " << motion->way << " m, " << motion->turn * deg_per_rad
                           << " deg from " << motion->time << ", " << motion->is_measured;
    }
  }
}

TEST(SeenMotion, ADriveATurnACreepAndAStartAreSeenAndMeasured) {
  struct Case {
    std::vector<sim::Twist> legs;
    double from, way, turn;  // s, m, rad
  };
  const std::vector<Case> cases{{{{20, 1.0, 0}}, 0.5, 4, 0},
                                {{{20, 0, 0.3}}, 0.5, 0, 3.45},
                                {{{20, 0.02, 0}}, 4, 0.23, 0},
                                {{{5, 0, 0}, {1, 0.3, 0.2}, {20, 0, 0}}, 5.5, 0.3, 0.2}};
  for (const Case& one : cases) {
    for (unsigned seed = 1; seed <= 10; ++seed) {
      const auto motion = WatchedVehicle(seed).look(one.legs, people);
      ASSERT_TRUE(motion) << seed << ": " << one.way << " m, " << one.turn;
      EXPECT_TRUE(motion->is_measured);
      EXPECT_NEAR(motion->time, one.from, one.way < 0.25 && one.turn == 0 ? 2 : 0.6) << seed;
      EXPECT_GT(motion->way, 0.9 * one.way - 0.05) << seed;
      EXPECT_NEAR(motion->turn, one.turn, 0.03) << seed;
    }
  }
}

TEST(SeenMotion, WhereThereAreNoSurfacesOtherSurroundingsShowIt) {
  // A wood: trunks of 0.3 m.
  for (unsigned seed = 1; seed <= 10; ++seed) {
    WatchedVehicle wood(seed);
    wood.yard = {};
    for (int i = 0; i < 250; ++i) {
      const Vector2d at(wood.random.within(30), wood.random.within(30));
      if (at.norm() > 3) wood.yard.add_box(at, {0.15, 0.15}, wood.random.within(1));
    }
    EXPECT_FALSE(wood.look({{20, 0, 0}}, people)) << seed;
    EXPECT_TRUE(wood.look({{20, 1.5, 0.05}}, nobody)) << seed;
  }
}

}  // namespace
}  // namespace lidard
