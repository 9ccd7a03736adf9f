// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Whole sweeps drawn into a raster: links, corners, ends.
#include <gtest/gtest.h>

#include "core/evidence/raster.h"
#include "test/core/evidence/raster_bench.h"
#include "test/sim/world/rng.h"

namespace lidard {
namespace {

using namespace test::raster;

/// A sweep of a scanner in the output's origin whose beams are 5 degrees apart.
struct Sweep {
  explicit Sweep(const std::vector<double>& ranges, double first_deg = 0.3, double step_deg = 5)
      : first(first_deg * degree), step(step_deg * degree) {
    scan.reset(ranges.size(), 1, true);
    scan.set_angles(static_cast<float>(first), static_cast<float>(step));
    scan.range_max = 100;
    rays.build(scan, Pose::Identity(), {}, {});
    const std::size_t n = ranges.size();
    sweep.linked.assign(n, 0);
    sweep.intensity.assign(n, 10);
    for (std::size_t i = 0; i < n; ++i) {
      const auto range = static_cast<float>(ranges[i]);
      sweep.range.push_back(range);
      sweep.kind.push_back(range > 0 ? Return::surface : Return::nothing);
      sweep.x.push_back(range * rays.x[i]);
      sweep.y.push_back(range * rays.y[i]);
    }
  }
  double angle(std::size_t beam) const { return first + static_cast<double>(beam) * step; }
  void link(std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < to; ++i) sweep.linked[i] = 1;
  }

  double first, step;
  PlanarScan scan;
  BeamRays rays;
  PlacedScan sweep;
};

TEST(Raster, SurfacesOfASweepAreDrawnBetweenLinkedReturnsAndNowhereElse) {
  for (const double turn : {0.3, 100.3, 170.3, -120.7}) {
    Sweep s({4, 4, 4, 0, 7, 3, 3}, turn);
    s.link(0, 2);
    s.link(5, 6);
    s.sweep.early_echoes.push_back(at(1.5, s.angle(3), 77));
    const ScanGrid grid = full_circle(360);
    Raster raster(grid);
    RangeLayer layer = empty_layer(grid);
    raster.draw(s.sweep, layer);
    for (std::size_t beam = 0; beam < 360; ++beam) {
      const double degrees = std::remainder(grid.angle(beam) - s.first, 2 * pi_d) / degree;
      const auto range = static_cast<double>(layer.range[beam]);
      const auto expected = [&]() -> double {
        if (degrees > -0.5 && degrees < 10.5) return 4;
        if (std::abs(degrees - 15) < 0.5) return 1.5;
        if (std::abs(degrees - 20) < 0.5) return 7;
        if (degrees > 24.5 && degrees < 30.5) return 3;
        return 0;
      }();
      if (expected == 0) {
        EXPECT_EQ(layer.range[beam], nothing) << turn << ' ' << degrees;
      } else {
        EXPECT_NEAR(range, expected, expected * 0.002) << turn << ' ' << degrees;
        EXPECT_NEAR(layer.intensity[beam], expected == 1.5 ? 77 : 10, 1e-3);
      }
    }
  }
}

TEST(Raster, ACornerIsDrawnAndNotCutOff) {
  // Walls x = 4 and y = 4 meet at 45 degrees, midway between two beams.
  Sweep s({4 / std::cos(37.5 * degree), 4 / std::cos(42.5 * degree), 4 / std::sin(47.5 * degree),
           4 / std::sin(52.5 * degree)},
          37.5);
  s.link(0, 3);
  s.sweep.corners.push_back({1, {4, 4, 10}});
  const ScanGrid grid = full_circle(720);
  Raster raster(grid);
  RangeLayer layer = empty_layer(grid);
  raster.draw(s.sweep, layer);
  for (const double degrees : {38.0, 41.0, 43.0, 44.0, 45.0, 46.0, 47.0, 50.0, 52.0}) {
    const double angle = degrees * degree;
    EXPECT_NEAR(layer.range[grid.nearest(angle)], 4 / std::max(std::cos(angle), std::sin(angle)), 1e-3)
        << degrees;
  }
  EXPECT_EQ(layer.range[grid.nearest(35 * degree)], nothing);
}

TEST(Raster, DoubtfulReturnsAreDrawnAsPointsInALayerOfTheirOwn) {
  Sweep s({4, 5, 6});
  s.sweep.kind[1] = Return::mixed_pixel;
  const ScanGrid grid = full_circle(360);
  Raster raster(grid);
  RangeLayer surfaces = empty_layer(grid), doubtful = empty_layer(grid);
  raster.draw(s.sweep, surfaces);
  raster.draw_mixed_pixels(s.sweep, doubtful);
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t beam = grid.nearest(s.angle(i));
    EXPECT_EQ(surfaces.range[beam] != nothing, i != 1);
    EXPECT_EQ(doubtful.range[beam] != nothing, i == 1);
  }
}

}  // namespace
}  // namespace lidard
