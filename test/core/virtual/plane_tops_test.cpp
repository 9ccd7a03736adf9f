// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// What is between two rings: tops of things near the plane of a virtual scan.
#include <gtest/gtest.h>

#include "test/core/virtual/cut_bench.h"
#include "test/core/virtual/small_lidar.h"

namespace lidard::test::cut {
namespace {

sim::Object turned_box(const Eigen::Vector3d& center, const Eigen::Vector3d& size, double yaw) {
  sim::Object object = box(center, size);
  object.pose = make_pose(center, {0, 0, yaw});
  return object;
}

double truth(const sim::Yard& yard, const Pose& frame, double angle) {
  const Eigen::Vector3d way(std::cos(angle), std::sin(angle), 0);
  return yard.cast({frame.translation(), frame.linear() * way}, false);
}

/// A block of that height, seen over a corner; the ring at -7 degrees meets it, the one at -5 degrees passes
/// over it everywhere.
struct Block {
  sim::Yard yard;
  Cut cut;
  Block(double height, double away, double wall_away = 25) {
    yard.objects = {turned_box({away, 0, height / 2}, {1.6, 1.6, height}, 45 * degree),
                    wall(wall_away, -40, wall_away, 40)};
    cut.make(seen(yard, lidar16()), lidar16().pose);
  }
  double at(const PlanarScan& scan, double deg) { return cut.range(scan, deg * degree); }
  double truth_at(double deg) const { return truth(yard, cut.frame, deg * degree); }
};

TEST(PlaneTops, AThingReachesThePlaneWhereAnyOfItsReturnsDoes) {
  Block block(0.65, 12.8);
  for (double deg = -4; deg <= 4; deg += 0.5) {
    ASSERT_LT(block.truth_at(deg), 14) << deg;
    EXPECT_NEAR(block.at(block.cut.safety, deg), block.truth_at(deg), 0.15) << deg;
  }
}

TEST(PlaneTops, AThingDoesNotReachThePlaneWhereItsTopIsSeenBeneath) {
  // Its front is square to the beams, and the ring meets its top: at one distance all along.
  sim::Yard yard;
  yard.objects = {box({12.9, 0, 0.2}, {2.4, 3, 0.4}), wall(25, -40, 25, 40)};
  Cut cut;
  cut.make(seen(yard, lidar16()), lidar16().pose);
  for (double deg = -4; deg <= 4; deg += 0.5) {
    EXPECT_NEAR(cut.range(cut.safety, deg * degree), truth(yard, cut.frame, deg * degree), 0.05) << deg;
    EXPECT_NEAR(cut.range(cut.strict, deg * degree), truth(yard, cut.frame, deg * degree), 0.05) << deg;
  }
}

/// A wall square to the beams, 0.6 m high and 8 m away; rings meet it 0.15 and 0.44 m high, the next one
/// passes at 0.73 m.
void expect_square_wall(const std::vector<sim::Object>& behind) {
  sim::Yard yard;
  yard.objects = {box({8.1, 0, 0.3}, {0.2, 3, 0.6}), wall(25, -40, 25, 40)};
  yard.objects.insert(yard.objects.end(), behind.begin(), behind.end());
  Cut cut;
  cut.settings.how.free_required = 20;
  cut.make(seen(yard, lidar16()), lidar16().pose);
  for (double deg = -6; deg <= 6; deg += 0.5) {
    const std::size_t beam = cut.grid.nearest(deg * degree);
    for (const PlanarScan* scan : {&cut.strict, &cut.safety}) {
      EXPECT_NE(scan->statuses[beam], BeamStatus::none) << deg;
      EXPECT_FALSE(scan->ranges[beam] > 9) << deg << ": overlooked";
    }
  }
}

TEST(PlaneTops, AFaceSquareToTheBeamsIsNoTop) { expect_square_wall({}); }

TEST(PlaneTops, WhatIsLowerThanAFaceIsNotItsTop) {
  // The ring that passes over the wall meets the table at 10.7 m, the wall behind it at 10.3 m.
  expect_square_wall({box({11, 0, 0.15}, {1.6, 3, 0.3})});
  expect_square_wall({box({10.4, 0, 0.225}, {0.2, 3.8, 0.45})});
}

TEST(PlaneTops, ALowThingStandsInTheGapBetweenTheRingsThatPassBeforeAndBehindIt) {
  // It is 7 cm higher than the plane: the ring at -15 degrees meets it 0.4 m high, that at -13 degrees
  // passes.
  sim::Yard yard;
  yard.objects = {box({5.8, -1.4, 0.285}, {0.06, 0.34, 0.57})};
  Cut cut;
  cut.frame = make_pose({6, 0, plane_height}, {0, 0, 0});
  cut.settings.how.free_required = 4;
  cut.make(seen(yard, lidar16()), lidar16().pose);
  for (double deg = -99; deg <= -97; deg += 0.5) {
    ASSERT_LT(truth(yard, cut.frame, deg * degree), 2) << deg;
    EXPECT_NE(cut.strict.statuses[cut.grid.nearest(deg * degree)], BeamStatus::none) << deg;
    EXPECT_NE(cut.safety.statuses[cut.grid.nearest(deg * degree)], BeamStatus::none) << deg;
  }
  EXPECT_EQ(cut.strict.statuses[cut.grid.nearest(-60 * degree)], BeamStatus::none) << "behind it all is free";
}

TEST(PlaneTops, WhatNobodyKnowsIsUnobservedInStrict) {
  // Its returns are up to 0.33 m high, the next beam passes at 0.7 m: the top may be anywhere in between.
  Block block(0.45, 14.7, 16.6);
  int silent = 0;
  for (double deg = -3; deg <= 3; deg += 0.5) {
    const double range = block.at(block.cut.strict, deg);
    silent += std::isnan(range) ? 1 : 0;
    EXPECT_FALSE(range < 16) << deg;
  }
  EXPECT_GT(silent, 6);
  // Of safety the wall behind is a hit, whose way proves nothing; beside the block it is free from where the
  // lowest ring, at -15 degrees, crosses the plane.
  const PlanarScan& safety = block.cut.safety;
  const std::size_t ahead = block.cut.grid.nearest(0);
  const std::size_t beside = block.cut.grid.nearest(20 * degree);
  ASSERT_EQ(safety.statuses[ahead], BeamStatus::hit);
  EXPECT_EQ(safety.free_from[ahead], safety.ranges[ahead]);
  ASSERT_EQ(safety.statuses[beside], BeamStatus::hit);
  EXPECT_NEAR(safety.free_from[beside], 1.5 / std::tan(15 * degree), 0.2);
}

TEST(PlaneTops, AWallGoesDownToThePlaneBehindAThingThatHidesItsFoot) {
  // From beside the lidar a virtual beam passes the thing and meets the wall where no ring does.
  sim::Yard yard;
  yard.objects = {box({8, 0, 0.55}, {0.5, 3, 1.1}), wall(22, -40, 22, 40)};
  Cut cut;
  cut.frame = make_pose({0, 3, plane_height}, {0, 0, 0});
  cut.make(seen(yard, lidar16()), lidar16().pose);
  int hidden = 0;
  for (double deg = -9; deg <= -2; deg += 0.5) {
    const double expected = truth(yard, cut.frame, deg * degree);
    if (expected < 10) continue;
    ++hidden;
    EXPECT_NEAR(cut.range(cut.safety, deg * degree), expected, 0.05) << deg;
  }
  EXPECT_GT(hidden, 8);
}

/// Of a lidar 1.5 m above the plane: the lowest ring meets the ground, the next one meets a thing at 8 m, the
/// next one a wall at 24 m, at these heights above the plane.
PlaneTops::Verdict verdict(double thing, double wall) {
  rings::SmallLidar lidar(1);
  lidar.elevations = {-0.6, std::atan2(thing - 1.5, 8), std::atan2(wall - 1.5, 24)};
  lidar.offsets.assign(3, 0);
  lidar.range = [&](std::size_t ring, std::size_t) {
    return ring == 0 ? 3 : ring == 1 ? std::hypot(8, thing - 1.5) : std::hypot(24, wall - 1.5);
  };
  RingGrid grid({});
  EXPECT_TRUE(grid.organise(lidar.cloud()));
  Ground ground;
  find_ground(grid, {}, make_pose({0, 0, 2}, {0, 0, 0}), ground);
  RingLinks links;
  links.set(grid, 0.005);
  PlaneView view;
  view.set_cloud(grid, ground, links, Eigen::Vector3f::UnitZ());
  view.set_frame(make_pose({0, 0, 1.5}, {0, 0, 0}));
  view.set_level(0);
  PlaneTops tops;
  tops.find(view);
  return static_cast<PlaneTops::Verdict>(tops.verdicts()[grid.index(100, 2)]);
}

TEST(PlaneTops, AWallMayGoDownToThePlaneWhereTheShadowOfWhatStandsBeforeItEndsBeneath) {
  // The line from the lidar over the return on the thing falls three times as far until it meets the wall:
  // from 1.5 m to the plane, if the return is 1 m above it.
  EXPECT_EQ(verdict(0.95, 1.2), PlaneTops::hides);
  EXPECT_EQ(verdict(0.4, 1.2), PlaneTops::hides);
  EXPECT_EQ(verdict(1.05, 1.2), PlaneTops::reaches) << "its foot is hidden";
  EXPECT_EQ(verdict(0.95, -0.1), PlaneTops::reaches) << "what is farther away lies beneath the plane";
}

}  // namespace
}  // namespace lidard::test::cut
