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
  s.sweep.kind[1] = Return::doubtful;
  const ScanGrid grid = full_circle(360);
  Raster raster(grid);
  RangeLayer surfaces = empty_layer(grid), doubtful = empty_layer(grid);
  raster.draw(s.sweep, surfaces);
  raster.draw_doubtful(s.sweep, doubtful);
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t beam = grid.nearest(s.angle(i));
    EXPECT_EQ(surfaces.range[beam] != nothing, i != 1);
    EXPECT_EQ(doubtful.range[beam] != nothing, i == 1);
  }
}

TEST(Raster, BehindTheEndsOfASurfaceTheBeamsAreMarkedAsFarAsTheNextBeamOfTheSource) {
  for (const double turn : {0.3, 120.3, 170.3, -178.7}) {
    // Returns 2 to 4 of 7 are one surface; return 6 stands alone at the end of the field of view.
    Sweep s({0, 0, 4, 4, 4, 0, 9}, turn);
    s.link(2, 4);
    const ScanGrid grid = full_circle(360);
    Raster raster(grid);
    RangeLayer layer = empty_layer(grid);
    raster.draw(s.sweep, layer);
    EndLayer ends;
    ends.clear(grid.beams);
    raster.mark_ends(s.sweep, s.rays, ends);
    for (std::size_t beam = 0; beam < 360; ++beam) {
      const double degrees = std::remainder(grid.angle(beam) - s.first, 2 * pi_d) / degree;
      // From the last return to the next beam, with the beams on either side of both directions.
      const bool before = degrees > 4 && degrees<11, after = degrees> 19 && degrees < 26;
      const bool alone = degrees > 24 && degrees < 36;
      EXPECT_EQ(ends.marked[beam] != 0, before || after || alone) << turn << ' ' << degrees;
      // Half of the way a surface more likely than not goes on.
      const auto range = static_cast<double>(ends.range[beam]);
      const bool likely = (degrees > 7.5 && degrees < 11) || (degrees > 19 && degrees < 22.5);
      if (likely) {
        EXPECT_NEAR(range, 4, 1e-4) << turn << ' ' << degrees;
      } else if (std::abs(degrees - 30) < 2.5) {
        EXPECT_NEAR(range, 9, 1e-4) << turn << ' ' << degrees;
      } else {
        EXPECT_EQ(ends.range[beam], nothing) << turn << ' ' << degrees;
      }
    }
  }
}

TEST(Raster, ASourceMountedUpsideDownEndsItsSurfacesAtTheSameBeams) {
  for (const double step : {5.0, -5.0}) {
    Sweep s({0, 4, 4, 4, 0}, 180.3 - 2 * step, step);
    s.link(1, 3);
    const ScanGrid grid = full_circle(360);
    Raster raster(grid);
    RangeLayer layer = empty_layer(grid);
    raster.draw(s.sweep, layer);
    EndLayer ends;
    ends.clear(grid.beams);
    raster.mark_ends(s.sweep, s.rays, ends);
    std::vector<int> marked;
    for (int beam = -15; beam <= 15; ++beam) {
      if (ends.marked[static_cast<std::size_t>((beam + 360) % 360)] != 0) marked.push_back(beam);
    }
    EXPECT_EQ(marked, (std::vector<int>{-10, -9, -8, -7, -6, -5, -4, 5, 6, 7, 8, 9, 10, 11})) << step;
  }
}

TEST(Raster, NoBeamIsMarkedThatTheOutputDoesNotHave) {
  // The output ends in the middle of what would be marked; one beam of its own stands for nothing behind it.
  const ScanGrid grid = span_of(-0.2, 0.2, degree);
  Raster raster(grid);
  Sweep s({4, 4, 4, 4}, 5);
  s.link(0, 2);
  RangeLayer layer = empty_layer(grid);
  raster.draw(s.sweep, layer);
  EndLayer ends;
  ends.clear(grid.beams);
  raster.mark_ends(s.sweep, s.rays, ends);
  EXPECT_EQ(ends.marked.size(), grid.beams);
  EXPECT_EQ(ends.marked[grid.nearest(2 * degree)], 1);
  EXPECT_EQ(ends.marked[grid.nearest(8 * degree)], 0);
  EXPECT_EQ(ends.marked[grid.nearest(-10 * degree)], 0);
}

TEST(Raster, ASingleBeamHasNoNeighbourToEndAt) {
  const ScanGrid grid = full_circle(360);
  Raster raster(grid);
  Sweep s({4});
  RangeLayer layer = empty_layer(grid);
  raster.draw(s.sweep, layer);
  EndLayer ends;
  ends.clear(grid.beams);
  raster.mark_ends(s.sweep, s.rays, ends);
  EXPECT_EQ(std::count(ends.marked.begin(), ends.marked.end(), 1), 0);
}

}  // namespace
}  // namespace lidard
