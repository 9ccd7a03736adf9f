// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/evidence/beam_rays.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "core/base/angle.h"
#include "test/sim/world/rng.h"

namespace lidard {
namespace {

/// A convex outline of some corners around a point, either way round.
std::vector<Eigen::Vector2d> random_outline(sim::Rng& rng) {
  std::vector<Eigen::Vector2d> corners;
  const Eigen::Vector2d middle(rng.within(3), rng.within(3));
  const int count = 3 + static_cast<int>(rng.uniform() * 5);
  const double way = rng.uniform() < 0.5 ? -1 : 1;
  for (int i = 0; i < count; ++i) {
    const double a = way * 2 * pi_d * (i + 0.6 * rng.uniform()) / count;
    corners.push_back(middle + 2 * Eigen::Vector2d(std::cos(a), 0.7 * std::sin(a)));
  }
  return corners;
}

/// m inside (positive) or outside of a convex outline, by its edges' half planes.
double depth(const std::vector<Eigen::Vector2d>& corners, const Eigen::Vector2d& point) {
  double area = 0, least = 1e9;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2d &a = corners[i], &b = corners[(i + 1) % corners.size()];
    area += a.x() * b.y() - a.y() * b.x();
  }
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2d &a = corners[i], &b = corners[(i + 1) % corners.size()];
    const Eigen::Vector2d along = (b - a).normalized(), to = point - a;
    least = std::min(least, (along.x() * to.y() - along.y() * to.x()) * (area > 0 ? 1 : -1));
  }
  return least;
}

TEST(Footprint, HoldsWhatLiesOnTheInnerSideOfAllItsEdgesAndPaddingMovesThem) {
  sim::Rng rng(1);
  int inside = 0, outside = 0;
  for (int round = 0; round < 2000; ++round) {
    const auto corners = random_outline(rng);
    const Footprint body(corners);
    const Eigen::Vector2d point(rng.within(5), rng.within(5));
    for (const double margin : {0.0, 0.1, -0.1}) {
      const double far = depth(corners, point) + margin;
      if (std::abs(far) < 1e-6) continue;
      ASSERT_EQ(body.padded(margin).contains(point), far > 0) << round << ' ' << margin;
      ++(far > 0 ? inside : outside);
    }
    const Pose pose = make_pose({rng.within(9), rng.within(9), rng.within(1)}, {0, 0, rng.within(3)});
    const Eigen::Vector2d moved = (pose * Eigen::Vector3d(point.x(), point.y(), 0)).head<2>();
    if (std::abs(depth(corners, point)) > 1e-6) {
      ASSERT_EQ(body.transformed(pose).contains(moved), body.contains(point));
    }
  }
  EXPECT_GT(inside, 300);
  EXPECT_GT(outside, 1000);
}

TEST(Footprint, ARayCrossesItWhereItsPointsAreInside) {
  sim::Rng rng(2);
  int crossed = 0, missed = 0;
  for (int round = 0; round < 500; ++round) {
    const auto corners = random_outline(rng);
    const Footprint body(corners);
    const Eigen::Vector2d origin(rng.within(5), rng.within(5));
    const double angle = rng.within(3.2), length = 0.5 + rng.uniform();  // directions need not be 1 m long
    const Eigen::Vector2d direction = length * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    double in = -1, out = -1;
    for (double r = 0; r < 30; r += 0.004) {
      if (depth(corners, origin + r * direction) < 0) continue;
      if (in < 0) in = r;
      out = r;
    }
    const auto crossings = body.crossings(origin, direction);
    if (in >= 0 && out - in < 0.05) continue;
    ASSERT_EQ(crossings.size(), in >= 0 ? 1U : 0U) << round;
    if (crossings.empty()) {
      ++missed;
      continue;
    }
    ++crossed;
    ASSERT_NEAR(crossings[0].in, in, 0.005) << round;
    ASSERT_NEAR(crossings[0].out, out, 0.005) << round;
  }
  EXPECT_GT(crossed, 100);
  EXPECT_GT(missed, 100);
}

TEST(Footprint, ARayAlongAnEdgeCrossesItBetweenItsCornersOrNotAtAll) {
  sim::Rng rng(4);
  int crossed = 0;
  for (int round = 0; round < 2000; ++round) {
    const auto corners = random_outline(rng);
    const Eigen::Vector2d direction = (corners[1] - corners[0]).normalized();
    const Eigen::Vector2d origin = corners[0] - 4 * direction;
    const auto crossings = Footprint(corners).crossings(origin, direction);
    if (crossings.empty()) continue;
    ++crossed;
    ASSERT_NEAR(crossings.front().in, 4, 1e-6) << round;
    ASSERT_NEAR(crossings.back().out, 4 + (corners[1] - corners[0]).norm(), 1e-6) << round;
  }
  EXPECT_GT(crossed, 100);
}

PlanarScan scan_of(std::size_t beams, double first, double increment) {
  PlanarScan scan;
  scan.reset(beams);
  scan.set_angles(static_cast<float>(first), static_cast<float>(increment));
  return scan;
}

TEST(Footprint, ARayThroughTwoPartsOfItCrossesItTwice) {
  const Footprint forks({{0, 0}, {4, 0}, {4, 1}, {1, 1}, {1, 2}, {4, 2}, {4, 3}, {0, 3}});
  const auto across = forks.crossings({2, -1}, {0, 1});
  ASSERT_EQ(across.size(), 2U);
  EXPECT_NEAR(across[0].in, 1, 1e-12);
  EXPECT_NEAR(across[0].out, 2, 1e-12);
  EXPECT_NEAR(across[1].in, 3, 1e-12);
  EXPECT_NEAR(across[1].out, 4, 1e-12);
  // From the heel through the space between them into a part; through two corners.
  EXPECT_EQ(forks.crossings({0.5, 1.5}, {1, 0.2}).size(), 2U);
  EXPECT_EQ(forks.crossings({0.5, 1.5}, {1, 0}).size(), 1U);
  EXPECT_EQ(forks.crossings({1, -1}, {0, 1}).size(), 2U);

  BeamRays rays;
  rays.build(scan_of(1, 0, 0), make_pose({2, -1, 0}, {0, 0, pi_d / 2}), forks, {});
  EXPECT_NEAR(rays.own_from(0, 1), 0.95, 1e-5);
  EXPECT_NEAR(rays.own_from(0, 2.04F), 0.95, 1e-5);
  EXPECT_TRUE(std::isinf(rays.own_from(0, 2.5F)));
  EXPECT_NEAR(rays.own_from(0, 3.5F), 2.95, 1e-5);
  EXPECT_TRUE(std::isinf(rays.own_from(0, 4.1F)));
}

TEST(Footprint, TheSidesOfANarrowSlitOverlapWhenPadded) {
  for (const double width : {0.02, 0.05, 0.09}) {
    const double w = width / 2;
    const Footprint body({{-1, -0.6}, {1, -0.6}, {1, -w}, {0.4, -w}, {0.4, w}, {1, w}, {1, 0.6}, {-1, 0.6}});
    const Footprint padded = body.padded(0.05);
    for (double y = -0.64; y < 0.65; y += 0.005) EXPECT_TRUE(padded.contains({0.7, y})) << width << ' ' << y;
    const auto crossings = padded.crossings({0, 0}, {1, 0});
    ASSERT_EQ(crossings.size(), 1U) << width;
    EXPECT_NEAR(crossings[0].out, 1.05, 1e-9);
  }
}

TEST(Footprint, ASpikeIsCutOffAtFourMargins) {
  const Footprint spike = Footprint({{0, -0.01}, {10, 0}, {0, 0.01}}).padded(0.1);
  EXPECT_TRUE(spike.contains({10.3, 0}));
  EXPECT_FALSE(spike.contains({10.45, 0}));
}

TEST(BeamRays, PointWhereTheMountSaysAndKnowTheBandTheyCross) {
  sim::Rng rng(3);
  int limited = 0;
  for (int round = 0; round < 50; ++round) {
    const double first = rng.within(3), increment = rng.uniform() < 0.5 ? 0.02 : -0.03;
    const PlanarScan scan = scan_of(100, first, increment);
    const Pose mount = make_pose({rng.within(3), rng.within(3), rng.within(1)},
                                 {rng.uniform() < 0.5 ? 0 : pi_d, rng.within(0.3), rng.within(3)});
    const HeightBand band{-0.5, 0.8};
    BeamRays rays;
    rays.build(scan, mount, {}, band);
    ASSERT_EQ(rays.size(), 100U);
    EXPECT_TRUE(rays.fits(scan, mount));
    for (std::size_t i = 0; i < 100; ++i) {
      const double angle = static_cast<double>(scan.angle_min) +
                           static_cast<double>(i) * static_cast<double>(scan.angle_increment);
      const Eigen::Vector3d ray = mount.linear() * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
      ASSERT_NEAR(rays.x[i], ray.x(), 1e-6);
      ASSERT_NEAR(rays.y[i], ray.y(), 1e-6);
      ASSERT_NEAR(rays.z[i], ray.z(), 1e-6);
      ASSERT_NEAR(rays.level[i], std::hypot(ray.x(), ray.y()), 1e-6);
      ASSERT_NEAR(rays.cosine[i], std::cos(angle), 1e-6);
      ASSERT_NEAR(rays.sine[i], std::sin(angle), 1e-6);
      for (double r = 0.01; r < 20; r += 0.37) {
        const double height = mount.translation().z() + r * ray.z();
        const double off = std::min(std::abs(height - band.min), std::abs(height - band.max));
        if (off < 1e-4) continue;
        const bool counts =
            r >= static_cast<double>(rays.band_begin[i]) && r <= static_cast<double>(rays.band_end[i]);
        ASSERT_EQ(counts, height > band.min && height < band.max) << round << ' ' << i << ' ' << r;
        limited += counts ? 0 : 1;
      }
    }
  }
  EXPECT_GT(limited, 10000);
}

TEST(BeamRays, ALevelBeamIsInTheBandEverywhereOrNowhere) {
  const PlanarScan scan = scan_of(3, 0, 0.1);
  for (const double height : {-0.6, -0.5, 0.0, 0.8, 0.9}) {
    BeamRays rays;
    rays.build(scan, make_pose({0, 0, height}, {0, 0, 1}), {}, {-0.5, 0.8});
    const bool inside = height > -0.55 && height < 0.85;
    EXPECT_EQ(rays.band_end[1] >= 1e6F, inside) << height;
    EXPECT_EQ(rays.band_end[1] < rays.band_begin[1], !inside) << height;
  }
}

TEST(BeamRays, FitOnlyTheScannerAndThePlaceTheyWereBuiltFor) {
  const PlanarScan scan = scan_of(100, 0.1, 0.02);
  BeamRays rays;
  rays.build(scan, make_pose({1, 0, 0}, {0, 0, 0}), {}, {});
  EXPECT_TRUE(rays.fits(scan, make_pose({1, 0, 0}, {0, 0, 0})));
  EXPECT_FALSE(rays.fits(scan, make_pose({1, 1e-6, 0}, {0, 0, 0})));
  EXPECT_FALSE(rays.fits(scan, make_pose({1, 0, 0}, {0, 0, 1e-6})));
  EXPECT_FALSE(rays.fits(scan_of(101, 0.1, 0.02), rays.pose));
  EXPECT_FALSE(rays.fits(scan_of(100, 0.11, 0.02), rays.pose));
  EXPECT_FALSE(rays.fits(scan_of(100, 0.1, 0.021), rays.pose));
}

TEST(BeamRays, KnowWhatOfThemIsTheVehicle) {
  const Footprint body({{-4, -1}, {0, -1}, {0, 1}, {-4, 1}});
  const PlanarScan scan = scan_of(1, 0, 0);
  const auto towards = [&](double x, double y, double yaw) {
    BeamRays rays;
    rays.build(scan, make_pose({x, y, 0.4}, {0, 0, yaw}), body, {});
    return rays;
  };
  // From outside straight at the body, whose margin is 5 cm.
  const BeamRays at = towards(2, 0, pi_d);
  EXPECT_NEAR(at.own_begin[0], 1.95, 1e-5);
  EXPECT_NEAR(at.own_end[0], 6.05, 1e-5);
  EXPECT_NEAR(at.blocked_at[0], 2, 0.005);
  EXPECT_EQ(at.from_inside[0], 0);
  const BeamRays past = towards(2, 1.2, pi_d);
  EXPECT_TRUE(std::isinf(past.own_begin[0]));
  EXPECT_TRUE(std::isinf(past.blocked_at[0]));
  // Within the margin but past the body: returns there are its own, and what is beyond is seen.
  const BeamRays graze = towards(2, 1.03, pi_d);
  EXPECT_NEAR(graze.own_begin[0], 1.95, 1e-5);
  EXPECT_TRUE(std::isinf(graze.blocked_at[0]));
  // From inside: a scanner sunk into the housing looks out of it, one in the middle does not.
  EXPECT_EQ(towards(-0.3, 0, 0).from_inside[0], 0);
  EXPECT_EQ(towards(-0.6, 0, 0).from_inside[0], 1);
  EXPECT_TRUE(std::isinf(towards(-0.6, 0, 0).blocked_at[0]));
  // Just before the front, looking back through all of the body.
  EXPECT_FALSE(std::isinf(towards(0.04, 0.7, pi_d).blocked_at[0]));
}

}  // namespace
}  // namespace lidard
