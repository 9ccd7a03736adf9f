// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "core/merge/merger.h"
#include "test/sim/world/flat_world.h"

namespace lidard {
namespace {

constexpr double deg = 3.14159265358979323846 / 180;

/// What is seen from the origin by scanners on the front corners of a vehicle that lies behind it.
PlanarScan look_from_before(double front) {
  sim::FlatWorld world;
  world.add_box({0, 0}, {12, 9}, 0);
  ScanGridSpec spec;
  spec.beams = 720;
  spec.range_max = 20;
  MergeSettings settings;
  settings.points = false;
  settings.visibility = true;
  settings.how.noise = settings.source.noise = 0.01;
  Merger merger(*make_grid(spec), {}, 2, settings);
  merger.set_footprint(Footprint({{-4, -1}, {front, -1}, {front, 1}, {-4, 1}}));
  for (std::size_t s = 0; s < 2; ++s) {
    const double side = s == 0 ? 1 : -1;
    sim::FlatScanner scanner;
    scanner.at = {front, side};
    scanner.yaw = side * 45 * deg;
    scanner.increment = 0.5 * deg;
    sim::Rng rng(1);
    PlanarScan scan;
    scanner.measure(world, rng, scan);
    scan.stamp = Stamp{1'700'000'000'000'000'000};
    merger.add(s, scan, scanner.pose());
  }
  PlanarScan out;
  merger.merge({Stamp{1'700'000'000'000'000'000}}, {1, 1}, {{Profile::strict, &out}}, nullptr);
  return out;
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

}  // namespace
}  // namespace lidard
