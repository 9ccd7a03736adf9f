// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/base/angle.h"
#include "core/evidence/placed_scan.h"
#include "test/sim/world/rng.h"
#include "test/sim/world/units.h"

namespace lidard {
namespace {

/// Returns of a scanner whose beam i points at i times `step_deg`.
struct Returns {
  Returns(const std::vector<double>& ranges, double step_deg) {
    scan.reset(ranges.size(), 1, false);
    scan.set_angles(0, static_cast<float>(step_deg * degree));
    rays.build(scan, Pose::Identity(), {}, {});
    for (std::size_t i = 0; i < ranges.size(); ++i) {
      const auto range = static_cast<float>(ranges[i]);
      sweep.range.push_back(range);
      sweep.kind.push_back(range > 0 ? Return::surface : Return::nothing);
      sweep.x.push_back(range * rays.x[i]);
      sweep.y.push_back(range * rays.y[i]);
    }
    sweep.linked.assign(ranges.size(), 0);
  }
  Returns& link(double noise) {
    link_neighbours(rays, noise, sweep);
    return *this;
  }
  bool linked(std::size_t i) const { return sweep.linked[i] != 0; }

  PlanarScan scan;
  BeamRays rays;
  PlacedScan sweep;
};

/// Ranges at which beams of `step_deg` meet a line `distance` m away, whose nearest point is at `normal_deg`.
std::vector<double> wall(double distance, double normal_deg, double step_deg, std::size_t beams) {
  std::vector<double> ranges;
  for (std::size_t i = 0; i < beams; ++i)
    ranges.push_back(distance / std::cos((static_cast<double>(i) * step_deg - normal_deg) * degree));
  return ranges;
}

/// Degrees between the line through two returns and the beam of the nearer one.
double steepness(double a, double b, double step_deg) {
  const double near = std::min(a, b), far = std::max(a, b);
  const Eigen::Vector2d p(near, 0), q(far * std::cos(step_deg * degree), far * std::sin(step_deg * degree));
  const Eigen::Vector2d line = q - p;
  return std::atan2(line.y(), line.x()) / degree;
}

TEST(Continuity, TwoReturnsAreOneSurfaceUnlessItWereSteeperThanNineDegreesAgainstTheBeam) {
  sim::Rng rng(1);
  int one = 0, two = 0;
  for (int round = 0; round < 3000; ++round) {
    const double step = 0.1 + 3.9 * rng.uniform();
    const double a = 0.5 + 20 * rng.uniform();
    const double b = a * (1 + 0.6 * (2 * rng.uniform() - 1) * std::min(1.0, step / 2));
    const double steep = steepness(a, b, step);
    if (std::abs(steep - 9) < 0.05) continue;
    const bool linked = Returns({0, a, b, 0}, step).link(0).linked(1);
    ASSERT_EQ(linked, steep > 9) << a << ", " << b << ", " << step << " deg: " << steep;
    ++(linked ? one : two);
  }
  EXPECT_GT(one, 500);
  EXPECT_GT(two, 500);
}

TEST(Continuity, NoiseOfThreeStandardDeviationsBreaksNoSurface) {
  for (const double step : {0.25, 1.0}) {
    const double longest = 5 * std::sin(step * degree) / std::sin((9 - step) * degree);
    // A step straight back is that chord but for the width between the beams.
    const double back = std::sqrt(longest * longest - std::pow(5 * step * degree, 2));
    EXPECT_TRUE(Returns({0, 5, 5 + back + 0.05, 0}, step).link(0.02).linked(1)) << step;
    EXPECT_FALSE(Returns({0, 5, 5 + back + 0.09, 0}, step).link(0.02).linked(1)) << step;
  }
}

TEST(Continuity, WithoutReturnNothingIsLinked) {
  Returns r({5, 0, 5, 5}, 1);
  r.link(0.01);
  EXPECT_EQ(r.sweep.linked, (std::vector<char>{0, 0, 1, 0}));
}

TEST(Continuity, AWallAtAGrazingAngleIsKnownByFourReturnsOnALine) {
  for (const double grazing : {3.0, 5.0, 7.0}) {
    // The beams reach the wall at that angle at their end, and more steeply before.
    const double step = 0.5;
    const auto ranges = wall(1, -(90 - grazing) + 7 * step, step, 8);
    Returns r(ranges, step);
    r.link(0.001);
    ASSERT_LT(steepness(ranges[5], ranges[6], step), 9) << grazing;
    EXPECT_TRUE(r.linked(4)) << grazing;
    EXPECT_TRUE(r.linked(5)) << grazing;
    // With one of the four missing, or off the line, the beam is not linked.
    for (const std::size_t other : {4U, 7U}) {
      auto without = ranges;
      without[other] = 0;
      EXPECT_FALSE(Returns(without, step).link(0.001).linked(5)) << grazing << " without " << other;
      auto off = ranges;
      off[other] *= 1.2;
      EXPECT_FALSE(Returns(off, step).link(0.001).linked(5)) << grazing << " off " << other;
    }
  }
}

TEST(Continuity, StepsAlongAGrazingWallOfMoreThanThreeMetresAreNotBelieved) {
  const auto longest_link = [](double distance) {
    const double step = 0.5;
    const auto ranges = wall(distance, -89.9 + 30 * step, step, 31);
    Returns r(ranges, step);
    r.link(0.001);
    double longest = 0;
    for (std::size_t i = 0; i + 1 < ranges.size(); ++i) {
      if (r.linked(i)) longest = std::max(longest, ranges[i + 1] - ranges[i]);
    }
    return longest;
  };
  EXPECT_LE(longest_link(1), 3.01);
  EXPECT_GT(longest_link(1), 1);
}

TEST(Continuity, ASteepLinkBetweenTwoSurfacesThatGoOnIsNone) {
  // Two walls straight across, beams of 2 degrees: the rule alone would bridge a step of 0.8 m at 4 m.
  const auto breaks = [](double depth, double noise) {
    std::vector<double> ranges = wall(4, 7, 2, 4);
    const auto behind = wall(4 + depth, 7 - 8, 2, 4);
    ranges.insert(ranges.end(), behind.begin(), behind.end());
    Returns r(ranges, 2);
    r.link(noise);
    std::vector<int> found;
    for (std::size_t i = 0; i + 1 < 8; ++i) {
      if (!r.linked(i)) found.push_back(static_cast<int>(i));
    }
    return found;
  };
  EXPECT_EQ(breaks(0.6, 0.001), (std::vector<int>{3}));
  EXPECT_EQ(breaks(0.4, 0.001), (std::vector<int>{3}));
  EXPECT_EQ(breaks(0.05, 0.001), (std::vector<int>{})) << "not steep";
  EXPECT_EQ(breaks(0.4, 0.1), (std::vector<int>{})) << "noise could be it";
}

TEST(Continuity, ALinkAtTheEndOfASurfaceIsNoBridge) {
  // Behind the step only one return follows: it does not go on.
  std::vector<double> ranges = wall(4, 7, 2, 4);
  ranges.push_back(4.6);
  Returns r(ranges, 2);
  r.link(0.001);
  EXPECT_TRUE(r.linked(3));
}

TEST(Continuity, AReturnBetweenANearAndAFarSurfaceIsAVeil) {
  for (const double veil : {4.5, 5.0, 6.0, 7.5}) {
    for (const bool near_first : {true, false}) {
      std::vector<double> ranges = {4, 4, 4, veil, 8, 8, 8};
      if (!near_first) ranges = {8, 8, 8, veil, 4, 4, 4};
      Returns r(ranges, 0.5);
      r.link(0.01);
      mark_mixed_pixels(r.rays, 0.01, r.sweep);
      for (std::size_t i = 0; i < 7; ++i)
        EXPECT_EQ(r.sweep.kind[i], i == 3 ? Return::mixed_pixel : Return::surface) << veil << ' ' << i;
      EXPECT_EQ(r.sweep.linked, (std::vector<char>{1, 1, 0, 0, 1, 1, 0})) << veil;
      EXPECT_EQ(r.sweep.mixed_pixels, 1U);
    }
  }
}

TEST(Continuity, WhatStandsAloneBeforeOrBehindIsNoVeil) {
  for (const double range : {2.0, 10.0}) {
    Returns r({4, 4, 4, range, 8, 8, 8}, 0.5);
    r.link(0.01);
    mark_mixed_pixels(r.rays, 0.01, r.sweep);
    EXPECT_EQ(r.sweep.kind[3], Return::surface) << range;
  }
  Returns open({4, 4, 4, 6, 0, 0, 0}, 0.5);
  open.link(0.01);
  mark_mixed_pixels(open.rays, 0.01, open.sweep);
  EXPECT_EQ(open.sweep.kind[3], Return::surface) << "nothing is behind it";
}

/// The corner behind a beam. Others may be found only where a return is anyhow: there they change nothing.
const PlacedScan::Corner* corner_at(const PlacedScan& sweep, std::size_t beam) {
  const PlacedScan::Corner* found = nullptr;
  for (const PlacedScan::Corner& corner : sweep.corners) {
    if (corner.beam == beam) found = &corner;
    double off = corner.beam == beam ? 0 : 1;
    for (std::size_t i = 0; i < sweep.x.size(); ++i)
      off =
          std::min(off, static_cast<double>(std::hypot(corner.at.x - sweep.x[i], corner.at.y - sweep.y[i])));
    EXPECT_LT(off, 1e-3) << corner.beam;
  }
  return found;
}

TEST(Continuity, ACornerIsWhereTheTwoWallsMeet) {
  sim::Rng rng(4);
  int found = 0;
  for (int round = 0; round < 300; ++round) {
    // Two walls that meet at a corner straight ahead of the middle, at any angle between them.
    const double step = 2;
    const double at = 11 + (2 * rng.uniform() - 1) * 0.8;  // degrees, between beams 5 and 6
    const double bend = 25 + 60 * rng.uniform();           // degrees of turn at the corner
    const double tilt = (2 * rng.uniform() - 1) * 20;
    const Eigen::Vector2d corner = 5 * Eigen::Vector2d(std::cos(at * degree), std::sin(at * degree));
    const auto meet = [&](double angle_deg, double direction_deg) {
      const Eigen::Vector2d ray(std::cos(angle_deg * degree), std::sin(angle_deg * degree));
      const Eigen::Vector2d along(std::cos(direction_deg * degree), std::sin(direction_deg * degree));
      return (corner.x() * along.y() - corner.y() * along.x()) / (ray.x() * along.y() - ray.y() * along.x());
    };
    std::vector<double> ranges;
    const double first = at + 90 + tilt - bend / 2, second = at + 90 + tilt + bend / 2;
    bool good = true;
    for (std::size_t i = 0; i < 12; ++i) {
      const double angle = static_cast<double>(i) * step;
      ranges.push_back(meet(angle, angle < at ? first : second));
      good = good && ranges.back() > 0.5 && ranges.back() < 30;
    }
    if (!good) continue;
    Returns r(ranges, step);
    r.link(0.001);
    if (!r.linked(4) || !r.linked(5) || !r.linked(6)) continue;
    find_corners(0.001, r.sweep);
    const PlacedScan::Corner* corner_found = corner_at(r.sweep, 5);
    ASSERT_NE(corner_found, nullptr) << round;
    EXPECT_NEAR(corner_found->at.x, corner.x(), 2e-3) << bend;
    EXPECT_NEAR(corner_found->at.y, corner.y(), 2e-3) << bend;
    ++found;
  }
  EXPECT_GT(found, 50);
}

TEST(Continuity, AStraightOrGentlyBentWallHasNoCorner) {
  for (const double normal : {0.0, 10.0, 40.0}) {
    Returns r(wall(4, normal, 2, 12), 2);
    r.link(0.001);
    find_corners(0.001, r.sweep);
    EXPECT_TRUE(r.sweep.corners.empty()) << normal;
  }
  // A round pillar of 2 m, seen by beams of 1 degree: it bends by less than 20 degrees from beam to beam.
  std::vector<double> round;
  for (int i = -10; i <= 10; ++i)
    round.push_back(4 * std::cos(i * degree) - std::sqrt(4 - std::pow(4 * std::sin(i * degree), 2)));
  Returns r(round, 1);
  r.link(0.001);
  find_corners(0.001, r.sweep);
  EXPECT_TRUE(r.sweep.corners.empty());
}

TEST(Continuity, ACornerHasTheIntensityBetweenItsNeighbours) {
  std::vector<double> ranges;
  for (int i = 0; i < 8; ++i) {
    const double angle = (35.5 + 3 * i) * degree;
    ranges.push_back(3 / std::max(std::cos(angle), std::sin(angle)));
  }
  Returns r(ranges, 3);
  r.link(0.001);
  find_corners(0.001, r.sweep);
  ASSERT_NE(corner_at(r.sweep, 3), nullptr);
  EXPECT_EQ(corner_at(r.sweep, 3)->at.intensity, 0);
  r.sweep.intensity = {10, 20, 30, 40, 60, 70, 80, 90};
  find_corners(0.001, r.sweep);
  ASSERT_NE(corner_at(r.sweep, 3), nullptr);
  EXPECT_EQ(corner_at(r.sweep, 3)->at.intensity, 50);
}

}  // namespace
}  // namespace lidard
