// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Frames turned in any way inside a closed room: every beam meets a flat surface, so that each range is
// exact.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "test/core/virtual/cut_bench.h"

namespace lidard {
namespace {

using namespace test::cut;

/// 12 x 9 x 5 m around the lidar.
sim::Yard room() {
  sim::Yard yard;
  yard.ground = false;
  yard.objects = {wall(6, -4.5, 6, 4.5, 3, -2),     wall(-6, -4.5, -6, 4.5, 3, -2),
                  wall(-6, 4.5, 6, 4.5, 3, -2),     wall(-6, -4.5, 6, -4.5, 3, -2),
                  box({0, 0, -2.1}, {14, 11, 0.2}), box({0, 0, 3.1}, {14, 11, 0.2})};
  return yard;
}

struct Counts {
  int beams = 0, exact = 0, near_an_edge = 0, wrong = 0, missing = 0;
};

/// Judges the beams whose surface lies between the lowest and the highest ring of the lidar.
void judge(const PlanarScan& scan, const Cut& cut, const sim::Yard& yard, const sim::YardLidar& lidar,
           Counts& counts) {
  for (std::size_t beam = 0; beam < scan.beams; ++beam) {
    const double angle = cut.grid.angle(beam);
    const Eigen::Vector3d ray = cut.frame.linear() * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
    const double truth = yard.cast({cut.frame.translation(), ray}, false);
    const Eigen::Vector3d seen = lidar.pose.inverse() * (cut.frame.translation() + truth * ray);
    const double elevation = std::asin(seen.z() / seen.norm());
    if (elevation < lidar.elevations[1] || elevation > lidar.elevations[lidar.elevations.size() - 2])
      continue;
    ++counts.beams;
    if (scan.statuses[beam] != BeamStatus::hit) {
      ++counts.missing;
      continue;
    }
    const double error = std::abs(static_cast<double>(scan.ranges[beam]) - truth);
    ++(error < 0.005 ? counts.exact : error < 0.15 ? counts.near_an_edge : counts.wrong);
  }
}

std::string text(const Counts& c) {
  return std::to_string(c.beams) + " beams: exact " + std::to_string(c.exact) + ", near an edge " +
         std::to_string(c.near_an_edge) + ", wrong " + std::to_string(c.wrong) + ", missing " +
         std::to_string(c.missing);
}

Counts look(double most_tilt, bool strict, const Pose& mount = Pose::Identity()) {
  const sim::Yard yard = room();
  sim::YardLidar lidar;
  lidar.elevations = sim::even_rings(48, -47, 47);
  lidar.columns = 720;
  lidar.pose = mount;
  const Cloud cloud = seen(yard, lidar);
  Counts counts;
  sim::Rng rng(7);
  const auto draw = [&rng](double reach) { return reach * (2 * rng.uniform() - 1); };
  for (int round = 0; round < 12; ++round) {
    Cut cut;
    cut.settings.ground.model = GroundModel::none;
    cut.settings.how.noise = 0.001;
    cut.frame = make_pose({draw(1), draw(1), draw(0.5)}, {draw(most_tilt), draw(most_tilt), draw(3)});
    cut.make(cloud, lidar.pose);
    judge(strict ? cut.strict : cut.safety, cut, yard, lidar, counts);
  }
  return counts;
}

TEST(VirtualRoom, ALevelFrameMeetsTheWallsExactly) {
  const Counts counts = look(0, false);
  SCOPED_TRACE(text(counts));
  EXPECT_GT(counts.beams, 8000);
  EXPECT_GE(counts.exact, counts.beams * 0.98);
  EXPECT_EQ(counts.wrong, 0);
  EXPECT_EQ(counts.missing, 0);
}

TEST(VirtualRoom, ATiltedFrameMeetsWallsFloorAndCeilingExactly) {
  for (const double tilt : {0.1, 0.5, 1.2}) {
    const Counts counts = look(tilt, false);
    SCOPED_TRACE(text(counts));
    EXPECT_GT(counts.beams, 4000);
    EXPECT_GE(counts.exact, counts.beams * 0.945) << tilt;
    // Where floor and wall meet at a slant the surface of either may end a beam too early, as may a floor
    // whose end beneath the plane only some columns show.
    EXPECT_LE(counts.wrong, counts.beams * 0.017) << tilt;
    EXPECT_LE(counts.missing, counts.beams * 0.025) << tilt;
  }
}

TEST(VirtualRoom, TheMountOfTheLidarChangesNothing) {
  for (const double roll : {0.15, pi_d, pi_d - 0.15}) {  // also upside down
    const Counts counts = look(0.1, false, make_pose({0.3, -0.4, 0.2}, {roll, -0.1, 2}));
    SCOPED_TRACE(text(counts));
    EXPECT_GE(counts.exact, counts.beams * 0.95);
    EXPECT_EQ(counts.wrong, 0);
    EXPECT_LE(counts.missing, counts.beams * 0.01);
  }
}

TEST(VirtualRoom, WhatIsProvenIsMostOfIt) {
  for (const double roll : {0.0, pi_d}) {
    const Counts counts = look(0.05, true, make_pose({0, 0, 0}, {roll, 0, 0}));
    SCOPED_TRACE(text(counts));
    EXPECT_GE(counts.exact, counts.beams * 0.9);
    EXPECT_EQ(counts.wrong, 0);
  }
}

}  // namespace
}  // namespace lidard
