// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/evidence/raster.h"

#include <gtest/gtest.h>

#include "test/core/evidence/raster_bench.h"
#include "test/sim/world/rng.h"

namespace lidard {
namespace {

using namespace test::raster;

TEST(Raster, PositionCountsBeamsFromTheFirstOneAllAround) {
  for (const ScanGrid& grid : grids()) {
    const Raster raster(grid);
    for (double angle = grid.angle_min + 1e-3; angle < grid.angle_min + 2 * pi_d; angle += 0.0371) {
      const Point p = at(3, angle);
      EXPECT_NEAR(static_cast<double>(raster.position(p.x, p.y)), (angle - grid.angle_min) / grid.increment,
                  1e-5 / grid.increment);
      float many[2];
      const float x[] = {p.x, p.x}, y[] = {p.y, p.y};
      raster.positions(x, y, 2, many);
      EXPECT_EQ(many[1], raster.position(p.x, p.y));
    }
  }
}

TEST(Raster, EveryBeamMeetsASegmentWhereItsRayDoes) {
  sim::Rng rng(1);
  std::size_t met = 0, missed = 0;
  for (int round = 0; round < 400; ++round) {
    const ScanGrid& grid = grids()[static_cast<std::size_t>(round) % grids().size()];
    const Raster raster(grid);
    const double towards = 2 * pi_d * rng.uniform();
    const Point p = at(1 + 9 * rng.uniform(), towards, 10 + 100 * rng.uniform());
    const Point q = at(1 + 9 * rng.uniform(), towards + (2 * rng.uniform() - 1) * 2.5, 100 * rng.uniform());
    RangeLayer layer = empty_layer(grid);
    raster.draw_segment(p, q, layer);
    for (std::size_t beam = 0; beam < grid.beams; ++beam) {
      const auto truth = meet(grid.angle(beam), p, q);
      if (!truth) {
        // Rounding may let a beam at the very end count.
        const double off = std::min(std::abs(std::remainder(grid.angle(beam) - angle_of(p), 2 * pi_d)),
                                    std::abs(std::remainder(grid.angle(beam) - angle_of(q), 2 * pi_d)));
        ASSERT_TRUE(layer.range[beam] == nothing || off < 1e-5) << round << ' ' << beam;
        ++missed;
        continue;
      }
      if (truth->share < 1e-4 || truth->share > 1 - 1e-4) continue;
      ++met;
      ASSERT_NEAR(static_cast<double>(layer.range[beam]), truth->range, truth->range * 2e-4) << round;
      const double between =
          static_cast<double>(p.intensity) +
          truth->share * (static_cast<double>(q.intensity) - static_cast<double>(p.intensity));
      ASSERT_NEAR(static_cast<double>(layer.intensity[beam]), between, 0.3) << round;
    }
  }
  EXPECT_GT(met, 10000U);
  EXPECT_GT(missed, 10000U);
}

TEST(Raster, TheNearerSurfaceStaysWithItsIntensityInWhateverOrderTheyCome) {
  const ScanGrid grid = full_circle(360);
  const Raster raster(grid);
  for (const bool near_first : {true, false}) {
    RangeLayer layer = empty_layer(grid);
    for (const bool near : {near_first, !near_first}) {
      const double range = near ? 2 : 5;
      raster.draw_segment(at(range, -0.3, range), at(range, 0.3, range), layer);
    }
    EXPECT_NEAR(layer.range[180], 2 * std::cos(0.3), 1e-3);
    EXPECT_EQ(layer.intensity[180], 2);
    for (const double range : {near_first ? 1.0 : 4.0, near_first ? 4.0 : 1.0})
      raster.draw_point(at(range, 1, range), layer);
    EXPECT_NEAR(layer.range[grid.nearest(1)], 1, 1e-5);
    EXPECT_EQ(layer.intensity[grid.nearest(1)], 1);
  }
}

TEST(Raster, OfASurfaceAlongTheBeamItsNearerEndCounts) {
  const ScanGrid grid = full_circle(360);
  const Raster raster(grid);
  for (const bool outwards : {true, false}) {
    RangeLayer layer = empty_layer(grid);
    const Point near = at(2, 0, 7), far = at(6, 0, 9);
    raster.draw_segment(outwards ? near : far, outwards ? far : near, layer);
    EXPECT_NEAR(layer.range[180], 2, 1e-5);
    EXPECT_EQ(layer.intensity[180], 7);
  }
}

TEST(Raster, APointIsDrawnInTheBeamNearestToIt) {
  sim::Rng rng(2);
  for (int round = 0; round < 3000; ++round) {
    const ScanGrid& grid = grids()[static_cast<std::size_t>(round) % grids().size()];
    const Raster raster(grid);
    const double angle = 2 * pi_d * rng.uniform();
    const double off_border = std::abs(std::remainder((angle - grid.angle_min) / grid.increment - 0.5, 1));
    if (off_border < 0.01) continue;
    RangeLayer layer = empty_layer(grid);
    raster.draw_point(at(4, angle, 55), layer);
    // The nearest of all beams, if one is not farther than half a beam.
    std::optional<std::size_t> nearest;
    for (std::size_t beam = 0; beam < grid.beams; ++beam) {
      if (std::abs(std::remainder(angle - grid.angle(beam), 2 * pi_d)) < grid.increment / 2) nearest = beam;
    }
    for (std::size_t beam = 0; beam < grid.beams; ++beam) {
      const bool here = nearest && *nearest == beam;
      ASSERT_EQ(layer.range[beam] != nothing, here) << angle << " beam " << beam;
      if (!here) continue;
      EXPECT_NEAR(layer.range[beam], 4, 1e-5);
      EXPECT_EQ(layer.intensity[beam], 55);
    }
  }
}

TEST(Raster, NothingIsDrawnAtTheOriginItself) {
  const ScanGrid grid = full_circle(360);
  const Raster raster(grid);
  RangeLayer layer = empty_layer(grid);
  raster.draw_point({0, 0, 1}, layer);
  raster.draw_point({0.0005F, 0, 1}, layer);
  raster.draw_end({0.0005F, 0, 1}, {0.0005F, 0.1F, 1}, raster.position(1, 0), layer);
  raster.draw_segment({0.0005F, 0, 1}, {0.0004F, 0.0001F, 1}, layer);
  for (const float range : layer.range) EXPECT_EQ(range, nothing);
  raster.draw_point({0.002F, 0, 1}, layer);
  EXPECT_NEAR(layer.range[180], 0.002, 1e-6);
}

TEST(Raster, TheEndOfASurfaceIsDrawnOutToTheMiddleOfItsBeam) {
  sim::Rng rng(3);
  const ScanGrid grid = full_circle(360);
  const Raster raster(grid);
  int drawn = 0;
  for (int round = 0; round < 500; ++round) {
    const double towards = 2 * pi_d * rng.uniform() - pi_d;
    const Point end = at(3, towards, 40);
    // The rest of the surface lies to one side, more or less across the beam.
    const double slant = (2 * rng.uniform() - 1) * 0.8;
    const double side = rng.uniform() < 0.5 ? 1 : -1;
    const double along = towards + side * (pi_d / 2 + slant);
    const Point inner{end.x + static_cast<float>(0.2 * std::cos(along)),
                      end.y + static_cast<float>(0.2 * std::sin(along)), 40};
    RangeLayer layer = empty_layer(grid);
    raster.draw_end(end, inner, raster.position(end.x, end.y), layer);
    const std::size_t beam = grid.nearest(towards);
    for (std::size_t i = 0; i < grid.beams; ++i) ASSERT_EQ(layer.range[i] != nothing, i == beam) << round;
    // The line through both, met by the beam's own ray on the surface or as far beyond its end.
    const Point beyond{2 * end.x - inner.x, 2 * end.y - inner.y, 0};
    const double exact = meet(grid.angle(beam), inner, beyond).value_or(Meeting{0, 0}).range;
    const auto range = static_cast<double>(layer.range[beam]);
    ASSERT_GT(exact, 0);
    ASSERT_NEAR(range, exact, 1e-3) << round;
    EXPECT_EQ(layer.intensity[beam], 40);
    ++drawn;
  }
  EXPECT_EQ(drawn, 500);
}

TEST(Raster, TheEndOfASlantingSurfaceStaysWhereItIs) {
  const ScanGrid grid = full_circle(360);
  const Raster raster(grid);
  // Nearly along the beam: drawn out it would be far away.
  const Point end = at(5, 0.4 * degree, 1);
  const Point inner = at(6, 0.45 * degree, 1);
  RangeLayer layer = empty_layer(grid);
  raster.draw_end(end, inner, raster.position(end.x, end.y), layer);
  EXPECT_NEAR(layer.range[180], 5, 1e-4);
}

}  // namespace
}  // namespace lidard
