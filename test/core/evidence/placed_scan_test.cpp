// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/evidence/placed_scan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/angle.h"
#include "test/sim/world/flat_world.h"
#include "test/sim/world/units.h"

namespace lidard {
namespace {

using sim::FlatScanner;
using sim::FlatWorld;

/// A scanner in a world, measured and conditioned.
struct Conditioned {
  Conditioned(const FlatWorld& world, const FlatScanner& scanner, const Footprint& body = {},
              double noise = 0.001, std::uint64_t seed = 1) {
    sim::Rng rng(seed);
    scanner.measure(world, rng, scan);
    settings.noise = noise;
    take(scanner.pose(), body, {});
  }
  void take(const Pose& pose, const Footprint& body, HeightBand band) {
    rays.build(scan, pose, body, band);
    condition(scan, rays, settings, sweep);
  }
  std::size_t towards(double angle) const {
    return static_cast<std::size_t>(std::lround((angle - rays.angle_min) / rays.increment));
  }

  PlanarScan scan;
  SourceSettings settings;
  BeamRays rays;
  PlacedScan sweep;
};

FlatScanner scanner_at(double x, double y, double yaw_deg, double increment_deg) {
  FlatScanner scanner;
  scanner.at = {x, y};
  scanner.yaw = yaw_deg * degree;
  scanner.increment = increment_deg * degree;
  return scanner;
}

TEST(Footprint, KnowsInsideAndCrossingsWhicheverWayItsVerticesGo) {
  for (const bool reversed : {false, true}) {
    std::vector<Eigen::Vector2d> v = {{-4, -1}, {0, -1}, {0, 1}, {-4, 1}};
    if (reversed) std::reverse(v.begin(), v.end());
    const Footprint body(v);
    EXPECT_TRUE(body.contains({-2, 0}));
    EXPECT_FALSE(body.contains({1, 0}));
    const auto through = body.crossings({1, 0}, {-1, 0});
    ASSERT_EQ(through.size(), 1U);
    EXPECT_NEAR(through[0].in, 1, 1e-12);
    EXPECT_NEAR(through[0].out, 5, 1e-12);
    EXPECT_TRUE(body.crossings({1, 0}, {1, 0}).empty());
    EXPECT_EQ(body.crossings({-1, 0}, {0, 1}).at(0).in, 0);
  }
}

TEST(Footprint, PaddingMovesEveryEdgeOutwardAlsoWhenTheOriginIsOutside) {
  const Footprint padded = Footprint({{5, 5}, {7, 5}, {7, 6}, {5, 6}}).padded(0.5);
  EXPECT_TRUE(padded.contains({4.6, 4.6}));
  EXPECT_TRUE(padded.contains({7.4, 6.4}));
  EXPECT_FALSE(padded.contains({4.4, 5.5}));
  EXPECT_FALSE(padded.contains({6, 6.6}));
}

TEST(Footprint, TwoVerticesContainNothing) { EXPECT_TRUE(Footprint({{0, 0}, {1, 1}}).empty()); }

TEST(PlacedScan, ReturnsOfTheVehicleAreNeitherSurfaceNorFreeSpace) {
  // A scanner on the corner of a body of 4 x 2 m, and a mirror standing out of it.
  FlatWorld world;
  world.add_box({0, 0}, {20, 20}, 0);
  world.add_box({-1, 1}, {0.1, 0.04}, 0);
  const Footprint body({{-4, -1}, {0, -1}, {0, 1}, {-4, 1}});
  const Conditioned c(world, scanner_at(0, 1, 45, 0.5), body);
  EXPECT_GT(c.sweep.own_returns, 0U);
  for (std::size_t i = 0; i < c.scan.beams; ++i) {
    if (c.scan.ranges[i] > 1.2F) continue;
    EXPECT_EQ(c.sweep.kind[i], Return::nothing) << i;
    EXPECT_LE(c.sweep.free_to[i], 1.0F) << i;
  }
  EXPECT_GT(std::count(c.sweep.kind.begin(), c.sweep.kind.end(), Return::surface), 400);
}

TEST(PlacedScan, AReturnFromBeyondTheOutlineProvesThatItsBeamPassesTheVehicle) {
  FlatWorld world;
  world.add_box({0, 0}, {20, 20}, 0);
  Conditioned c(world, scanner_at(3, 0, 180, 0.5), Footprint({{-2, -1}, {2, -1}, {2, 1}, {-2, 1}}));
  EXPECT_GT(c.sweep.seen_through, 50U);
  const std::size_t middle = c.towards(0);
  EXPECT_EQ(c.sweep.kind[middle], Return::surface);
  EXPECT_NEAR(c.sweep.free_to[middle], 23, 0.1);
  // Without a return, too, from then on; a beam that has never had one ends at the outline.
  PlanarScan nothing = c.scan;
  for (std::size_t i = 0; i < nothing.beams; ++i) nothing.set_without_hit(i, BeamStatus::none);
  condition(nothing, c.rays, {}, c.sweep);
  EXPECT_GT(c.sweep.free_to[middle], 23);
  PlacedScan other;
  condition(nothing, c.rays, {}, other);
  EXPECT_NEAR(other.free_to[middle], 1, 0.01);
}

TEST(PlacedScan, OutlineThatReachesALittleBeyondAScannerOnItsBorderDoesNotBlindIt) {
  // The scanner stands on the left border, 0.1 m behind the front.
  FlatWorld world;
  world.add_box({0, 0}, {12, 12}, 0);
  const Conditioned c(world, scanner_at(0, 1, 45, 0.5), Footprint({{-4, -1}, {0.1, -1}, {0.1, 1}, {-4, 1}}));
  for (const double direction : {-75.0, -45.0, -10.0, 0.0, 60.0, 170.0}) {
    EXPECT_EQ(c.sweep.kind[c.towards((direction - 45) * degree)], Return::surface) << direction;
  }
  // Along the front, and through the body.
  EXPECT_EQ(c.sweep.seen_through, static_cast<std::uint64_t>(std::count(c.sweep.passes_vehicle.begin(),
                                                                        c.sweep.passes_vehicle.end(), 1)));
}

TEST(PlacedScan, ScannerAboveTheVehicleSeesOverIt) {
  FlatWorld world;
  world.add_box({0, 0}, {20, 20}, 0);
  const Conditioned c(world, scanner_at(0, 0, 0, 0.5), Footprint({{-2, -1}, {2, -1}, {2, 1}, {-2, 1}}));
  EXPECT_EQ(std::count(c.sweep.kind.begin(), c.sweep.kind.end(), Return::surface),
            static_cast<std::ptrdiff_t>(c.scan.beams) -
                std::count(c.scan.statuses.begin(), c.scan.statuses.end(), BeamStatus::none));
}

TEST(PlacedScan, WallIsOneSurfaceAtEveryDistanceAndAngle) {
  for (const double incidence : {10.0, 30.0, 60.0, 90.0}) {
    for (const double distance : {2.0, 5.0, 20.0}) {
      FlatWorld world;
      const Eigen::Vector2d along(std::cos(incidence * degree), std::sin(incidence * degree));
      const Eigen::Vector2d middle(distance, 0);
      world.add_wall(middle - distance / 4 * along, middle + distance / 4 * along);
      const Conditioned c(world, scanner_at(0, 0, 0, 0.5));
      std::size_t breaks = 0;
      for (std::size_t i = 0; i + 1 < c.scan.beams; ++i) {
        const bool both = c.sweep.kind[i] == Return::surface && c.sweep.kind[i + 1] == Return::surface;
        breaks += both && c.sweep.linked[i] == 0 ? 1 : 0;
      }
      EXPECT_EQ(breaks, 0U) << incidence << ' ' << distance;
    }
  }
}

TEST(PlacedScan, PostsBehindOneAnotherAndDoorwaysAreNotBridged) {
  FlatWorld posts;
  posts.add_wall({5, -1}, {5, 0});
  posts.add_wall({5.5, 0}, {5.5, 1});
  const Conditioned c(posts, scanner_at(0, 0, 0, 0.5));
  std::size_t breaks = 0;
  for (std::size_t i = c.towards(-5 * degree); i < c.towards(5 * degree); ++i)
    breaks += c.sweep.linked[i] == 0 ? 1 : 0;
  EXPECT_EQ(breaks, 1U);
  FlatWorld doorway;
  doorway.add_wall({10, -4}, {10, -0.3});
  doorway.add_wall({10, 0.3}, {10, 4});
  const Conditioned d(doorway, scanner_at(0, 0, 0, 0.5));
  std::size_t open = 0;
  for (std::size_t i = 0; i < d.scan.beams; ++i) {
    const double y = d.rays.angle_min + static_cast<double>(i) * d.rays.increment;
    open += std::abs(y) < 1.7 * degree && d.sweep.linked[i] == 0 ? 1 : 0;
  }
  EXPECT_GE(open, 5U);
}

TEST(PlacedScan, BeamsWiderApartThanTheSteepestSurfaceDoNotCrash) {
  FlatWorld world;
  world.add_box({0, 0}, {5, 5}, 0);
  const Conditioned c(world, scanner_at(0, 0, 0, 15));
  EXPECT_EQ(std::count(c.sweep.kind.begin(), c.sweep.kind.end(), Return::surface), 19);
}

TEST(PlacedScan, CornersAreWhereTheWallsMeet) {
  FlatWorld world;
  world.add_wall({4, 3}, {4, -3});
  world.add_wall({4, 3}, {-4, 3});
  const Conditioned c(world, scanner_at(0, 0, 0, 1));
  ASSERT_EQ(c.sweep.corners.size(), 1U);
  EXPECT_NEAR(c.sweep.corners[0].at.x, 4, 1e-3);
  EXPECT_NEAR(c.sweep.corners[0].at.y, 3, 1e-3);
}

/// Share of veil points found (those more than 0.3 m from both surfaces) and of good returns lost, in
/// percent.
struct VeilShares {
  double found, lost;
};

VeilShares veil_shares(double increment_deg, int scenes) {
  std::uint64_t veils = 0, found = 0, good = 0, lost = 0;
  for (int seed = 1; seed <= scenes; ++seed) {
    sim::Rng rng(static_cast<std::uint64_t>(seed));
    FlatWorld world;
    world.add_box({0, 0}, {15, 10}, 0);
    for (int box = 0; box < 12; ++box) {
      const Eigen::Vector2d at(rng.uniform() * 26 - 13, rng.uniform() * 16 - 8);
      if (at.norm() > 1.5)
        world.add_box(at, {0.05 + 0.75 * rng.uniform(), 0.05 + 0.75 * rng.uniform()}, rng.uniform() * 3);
    }
    FlatScanner scanner = scanner_at(0, 0, 0, increment_deg);
    scanner.noise = 0.01;
    scanner.spot = 0.1 * degree;
    const Conditioned c(world, scanner, {}, 0.01, static_cast<std::uint64_t>(seed));
    for (std::size_t i = 0; i < c.scan.beams; ++i) {
      if (c.scan.statuses[i] != BeamStatus::hit) continue;
      const double angle = c.rays.angle_min + static_cast<double>(i) * c.rays.increment;
      const auto r = static_cast<double>(c.scan.ranges[i]);
      const double left = world.cast({0, 0}, angle + scanner.spot),
                   right = world.cast({0, 0}, angle - scanner.spot);
      const double depth = std::min(r - std::min(left, right), std::max(left, right) - r);
      const bool veil = depth > 0.3;
      const bool marked = c.sweep.kind[i] == Return::mixed_pixel;
      veils += veil ? 1 : 0, found += veil && marked ? 1 : 0;
      good += depth < 0.05 ? 1 : 0, lost += depth < 0.05 && marked ? 1 : 0;
    }
  }
  return {100.0 * static_cast<double>(found) / static_cast<double>(veils),
          100.0 * static_cast<double>(lost) / static_cast<double>(good)};
}

TEST(PlacedScan, VeilPointsAreFoundAndGoodReturnsKept) {
  const struct { double increment, found; } bars[] = {{0.25, 90}, {0.5, 80}, {1, 50}};
  for (const auto& bar : bars) {
    const VeilShares shares = veil_shares(bar.increment, 200);
    EXPECT_GE(shares.found, bar.found) << bar.increment;
    EXPECT_LE(shares.lost, 0.15) << bar.increment;
    RecordProperty("found_" + std::to_string(bar.increment), std::to_string(shares.found));
  }
}

TEST(PlacedScan, WallBesideTheScannerLosesNothingToTheVeilFilter) {
  for (const double distance : {0.3, 0.5, 1.0}) {
    for (const double increment : {0.25, 0.5, 1.0}) {
      FlatWorld world;
      world.add_wall({-10, distance}, {10, distance});
      FlatScanner scanner = scanner_at(0, 0, 0, increment);
      scanner.noise = 0.01;
      const Conditioned c(world, scanner, {}, 0.01);
      EXPECT_EQ(c.sweep.mixed_pixels, 0U) << distance << ' ' << increment;
    }
  }
}

TEST(PlacedScan, BeamThatLeavesTheHeightBandProvesFreeSpaceOnlyUpToThere) {
  // 3 degrees down from 0.40 m, heights 0.05 to 0.60 m: the band ends at 6.68 m, the floor is met at 7.63 m.
  Conditioned c(FlatWorld(), scanner_at(0, 0, 0, 0.5));
  for (std::size_t i = 0; i < c.scan.beams; ++i) c.scan.set_hit(i, 7.64F);
  c.take(make_pose({0, 0, 0.4}, {0, 3 * degree, 0}), {}, {0.05, 0.60});
  const std::size_t ahead = c.towards(0);
  EXPECT_EQ(c.sweep.kind[ahead], Return::nothing);
  EXPECT_NEAR(c.sweep.free_to[ahead], 6.68, 0.01);
  // Sideways the beam stays level and its return counts.
  EXPECT_EQ(c.sweep.kind[c.towards(90 * degree)], Return::surface);
}

TEST(PlacedScan, WindowsOfRangeAndAngleLeaveReturnsOut) {
  FlatWorld world;
  world.add_box({0, 0}, {5, 5}, 0);
  Conditioned c(world, scanner_at(0, 0, 0, 1));
  c.settings.angle_min = -0.5;
  c.settings.angle_max = 0.5;
  c.settings.range_max = 5.2;
  c.take(Pose::Identity(), {}, {});
  EXPECT_EQ(c.sweep.kind[c.towards(10 * degree)], Return::surface);
  EXPECT_EQ(c.sweep.kind[c.towards(20 * degree)], Return::nothing);  // 5.3 m
  EXPECT_EQ(c.sweep.kind[c.towards(40 * degree)], Return::nothing);
}

TEST(PlacedScan, WindowOfAngleGoesThroughStraightBehind) {
  FlatWorld world;
  world.add_box({0, 0}, {5, 5}, 0);
  Conditioned c(world, scanner_at(0, 0, 0, 1));
  c.settings.angle_min = 100 * degree;
  c.settings.angle_max = -110 * degree;
  c.take(Pose::Identity(), {}, {});
  EXPECT_EQ(c.sweep.kind[c.towards(105 * degree)], Return::surface);
  EXPECT_EQ(c.sweep.kind[c.towards(-115 * degree)], Return::surface);
  EXPECT_EQ(c.sweep.kind[c.towards(-105 * degree)], Return::nothing);
  EXPECT_EQ(c.sweep.kind[c.towards(0)], Return::nothing);
}

TEST(PlacedScan, EchoesAreChosenAsAsked) {
  PlanarScan scan;
  scan.reset(3, 2, true);
  scan.set_angles(-0.01F, 0.01F);
  scan.range_max = 30;
  for (std::size_t i = 0; i < 3; ++i) {
    scan.set_hit(scan.index(i, 0), 4), scan.intensities[scan.index(i, 0)] = 200;
    scan.set_hit(scan.index(i, 1), 9), scan.intensities[scan.index(i, 1)] = 50;
  }
  const auto taken = [&](EchoChoice choice) {
    SourceSettings settings;
    settings.echoes = choice;
    BeamRays rays;
    rays.build(scan, Pose::Identity(), {}, {});
    PlacedScan sweep;
    condition(scan, rays, settings, sweep);
    return sweep;
  };
  EXPECT_EQ(taken(EchoChoice::first).range[1], 4);
  EXPECT_EQ(taken(EchoChoice::last).range[1], 9);
  EXPECT_EQ(taken(EchoChoice::strongest).range[1], 4);
  const PlacedScan all = taken(EchoChoice::all);
  EXPECT_EQ(all.range[1], 9);
  ASSERT_EQ(all.early_echoes.size(), 3U);
  EXPECT_NEAR(all.early_echoes[1].x, 4, 1e-5);
  EXPECT_EQ(all.free_to[1], 4);
}

TEST(PlacedScan, ScannerMountedUpsideDownSeesTheSameWorld) {
  FlatWorld world;
  world.add_box({1, 0.5}, {5, 3}, 0);
  Conditioned upright(world, scanner_at(0, 0, 0, 0.5));
  Conditioned turned(world, scanner_at(0, 0, 0, 0.5));
  std::reverse(turned.scan.ranges.begin(), turned.scan.ranges.end());
  turned.take(make_pose({0, 0, 0}, {pi_d, 0, 0}), {}, {});
  for (std::size_t i = 0; i < upright.scan.beams; ++i) {
    const std::size_t j = upright.scan.beams - 1 - i;
    EXPECT_NEAR(upright.sweep.x[i], turned.sweep.x[j], 1e-4);
    EXPECT_NEAR(upright.sweep.y[i], turned.sweep.y[j], 1e-4);
  }
}

TEST(PlacedScan, ATiltedBeamIsFreeWhereItIsWithinTheHeights) {
  FlatWorld world;
  world.add_box({20, 0}, {1, 30}, 0);
  Conditioned seen(world, scanner_at(0, 0, 0, 1));
  // 1 m high, 10 degrees down: the heights from 0.4 to -0.2 m begin 3.40 m ahead and end 6.81 m ahead.
  seen.take(make_pose({0, 0, 1}, {0, 10 * degree, 0}), {}, {-0.2, 0.4});
  const std::size_t ahead = seen.towards(0);
  EXPECT_NEAR(static_cast<double>(seen.sweep.free_from[ahead]), 0.6 / std::tan(10 * degree), 0.01);
  EXPECT_NEAR(static_cast<double>(seen.sweep.free_to[ahead]), 1.2 / std::tan(10 * degree), 0.01);
}

}  // namespace
}  // namespace lidard
