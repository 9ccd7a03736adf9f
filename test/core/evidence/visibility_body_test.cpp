// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/merge/merger.h"
#include "test/sim/world/flat_world.h"

namespace lidard {
namespace {

constexpr double deg = 3.14159265358979323846 / 180;

struct Mount {
  Eigen::Vector2d at;
  double yaw;  // deg
};

/// What is seen from the origin by scanners on a vehicle.
PlanarScan look(const sim::FlatWorld& world, const Footprint& footprint, const std::vector<Mount>& mounts) {
  ScanGridSpec spec;
  spec.beams = 720;
  spec.range_max = 20;
  MergeSettings settings;
  settings.points = false;
  settings.visibility = true;
  settings.how.noise = settings.source.noise = 0.01;
  Merger merger(*make_grid(spec), {}, mounts.size(), settings);
  merger.set_footprint(footprint);
  for (std::size_t s = 0; s < mounts.size(); ++s) {
    sim::FlatScanner scanner;
    scanner.at = mounts[s].at;
    scanner.yaw = mounts[s].yaw * deg;
    scanner.increment = 0.5 * deg;
    sim::Rng rng(1);
    PlanarScan scan;
    scanner.measure(world, rng, scan);
    scan.stamp = Stamp{1'700'000'000'000'000'000};
    merger.add(s, scan, scanner.pose());
  }
  PlanarScan out;
  merger.merge({Stamp{1'700'000'000'000'000'000}}, std::vector<char>(mounts.size(), 1),
               {{Profile::strict, &out}}, nullptr);
  return out;
}

/// Scanners on the front corners of a vehicle that lies behind the origin.
PlanarScan look_from_before(double front) {
  sim::FlatWorld world;
  world.add_box({0, 0}, {12, 9}, 0);
  return look(world, Footprint({{-4, -1}, {front, -1}, {front, 1}, {-4, 1}}),
              {{{front, 1}, 45}, {{front, -1}, -45}});
}

TEST(VisibilityBody, VehicleIsTransparentAlsoToAnOriginJustOutsideOfIt) {
  for (const double front : {0.0, -0.1, -0.5}) {
    const PlanarScan scan = look_from_before(front);
    std::size_t hits = 0, all = 0;
    for (std::size_t i = 0; i < scan.beams; ++i) {
      // Backward through the body, but not into the strip behind it that no scanner sees.
      const double angle = std::abs(static_cast<double>(scan.angle(i))) / deg;
      if (angle < 100 || angle > 155) continue;
      ++all;
      hits += scan.statuses[i] == BeamStatus::hit ? 1 : 0;
    }
    EXPECT_EQ(hits, all) << front;
  }
}

TEST(VisibilityBody, StripBehindTheVehicleStaysUnknown) {
  for (const double front : {0.0, -0.1, -0.5}) {
    const PlanarScan scan = look_from_before(front);
    for (std::size_t i = 0; i < scan.beams; ++i) {
      if (std::abs(static_cast<double>(scan.angle(i))) / deg < 170) continue;
      EXPECT_EQ(scan.statuses[i], BeamStatus::invalid) << front << " beam " << i;
    }
  }
}

/// A truck with forks at the height of its scanners: one on each front corner, perhaps one sunk into the
/// heel.
class Forks : public testing::Test {
 protected:
  Forks() {
    world.add_box({0, 0}, {12, 9}, 0);
    for (const double y : {0.35, -0.35}) world.add_box({1.6, y}, {0.59, 0.09}, 0);
  }
  /// By two scanners on the corners and `more`.
  PlanarScan seen(const std::vector<Mount>& more) const {
    std::vector<Mount> mounts = {{{1, 0.6}, 45}, {{1, -0.6}, -45}};
    mounts.insert(mounts.end(), more.begin(), more.end());
    return look(world,
                Footprint({{-1, -0.6},
                           {1, -0.6},
                           {1, -0.45},
                           {2.2, -0.45},
                           {2.2, -0.25},
                           {1, -0.25},
                           {1, 0.25},
                           {2.2, 0.25},
                           {2.2, 0.45},
                           {1, 0.45},
                           {1, 0.6},
                           {-1, 0.6}}),
                mounts);
  }
  /// Checks the beams between two angles, deg, of either side.
  static void expect(const PlanarScan& scan, double from, double to, BeamStatus status) {
    for (std::size_t i = 0; i < scan.beams; ++i) {
      const double angle = std::abs(static_cast<double>(scan.angle(i)));
      if (angle < from * deg || angle > to * deg) continue;
      EXPECT_EQ(scan.statuses[i], status) << angle / deg;
      if (status == BeamStatus::hit) {
        EXPECT_GT(scan.ranges[i], 11.9) << angle / deg;
      }
    }
  }
  sim::FlatWorld world;
  const Mount heel{{0.97, 0}, 0};
};

TEST_F(Forks, TheSpaceBetweenThemMustBeSeen) {
  // Through the space between them alone, and through it and a fork.
  const PlanarScan seen_by_three = seen({heel});
  expect(seen_by_three, 0, 4, BeamStatus::hit);
  expect(seen_by_three, 5.7, 7, BeamStatus::hit);
  // From the tips all is seen but that space.
  for (const auto& more : {std::vector<Mount>(), {{{2.2, 0.35}, 0}, {{2.2, -0.35}, 0}}}) {
    expect(seen(more), 0, 4, BeamStatus::invalid);
    expect(seen(more), 5.7, 7, BeamStatus::invalid);
  }
  expect(seen({heel, {{2.2, 0.35}, 0}, {{2.2, -0.35}, 0}}), 5.7, 7, BeamStatus::hit);
}

TEST_F(Forks, WhatStandsBetweenThemIsSeen) {
  for (const double y : {0.12, -0.12}) world.add_box({1.5, y}, {0.03, 0.03}, 0);
  const PlanarScan scan = seen({heel});
  for (const double side : {1.0, -1.0}) {
    const auto beam = static_cast<std::size_t>(360 + side * std::round(std::atan2(0.12, 1.5) / deg / 0.5));
    EXPECT_EQ(scan.statuses[beam], BeamStatus::hit);
    EXPECT_NEAR(scan.ranges[beam], 1.47, 0.04);
  }
}

TEST(VisibilityBody, OriginInAScannerLosesNoBeamWhereverTheScannerLooks) {
  for (const double yaw : {0.0, 90.0, 180.0, -100.0}) {
    sim::FlatWorld open;
    const PlanarScan scan = look(open, {}, {{{0, 0}, yaw}});
    for (std::size_t i = 0; i < scan.beams; ++i) {
      const double off = std::abs(std::remainder(static_cast<double>(scan.angle(i)) / deg - yaw, 360));
      if (std::abs(off - 135) < 1) continue;
      EXPECT_EQ(scan.statuses[i], off < 135 ? BeamStatus::none : BeamStatus::invalid) << yaw << ' ' << i;
    }
  }
}

}  // namespace
}  // namespace lidard
