// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/evidence/raster.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "core/base/angle.h"
#include "test/sim/world/rng.h"

namespace lidard {
namespace {

using Point = Raster::Point;

constexpr double degree = pi_d / 180;
constexpr float nothing = std::numeric_limits<float>::infinity();

ScanGrid full_circle(std::size_t beams) {
  ScanGridSpec spec;
  spec.beams = beams;
  return make_grid(spec).value();
}

ScanGrid span_of(double from, double to, double increment) {
  ScanGridSpec spec;
  spec.angle_min = from;
  spec.angle_max = to;
  spec.angle_increment = increment;
  return make_grid(spec).value();
}

const std::vector<ScanGrid>& grids() {
  static const std::vector<ScanGrid> all = {full_circle(360), full_circle(1441), span_of(-1, 1, 0.01),
                                            span_of(0.3, 5.9, 0.02), span_of(0, 2 * pi_d, 2 * degree)};
  return all;
}

RangeLayer empty_layer(const ScanGrid& grid) {
  RangeLayer layer;
  layer.clear(grid.beams);
  return layer;
}

double angle_of(const Point& p) { return std::atan2(static_cast<double>(p.y), static_cast<double>(p.x)); }
double range_of(const Point& p) { return std::hypot(static_cast<double>(p.x), static_cast<double>(p.y)); }

Point at(double range, double angle, double intensity = 0) {
  return {static_cast<float>(range * std::cos(angle)), static_cast<float>(range * std::sin(angle)),
          static_cast<float>(intensity)};
}

/// Where a ray from the origin meets the segment from p to q: m, and the share of the way from p.
struct Meeting {
  double range, share;
};
std::optional<Meeting> meet(double angle, const Point& p, const Point& q) {
  const double c = std::cos(angle), s = std::sin(angle);
  const double px = static_cast<double>(p.x), py = static_cast<double>(p.y);
  const double dx = static_cast<double>(q.x) - px, dy = static_cast<double>(q.y) - py;
  const double slope = c * dy - s * dx;
  if (std::abs(slope) < 1e-9) return std::nullopt;
  const double share = (s * px - c * py) / slope;
  const double range = (px * dy - py * dx) / slope;
  if (share < 0 || share > 1 || range <= 0) return std::nullopt;
  return Meeting{range, share};
}

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

TEST(Raster, BeamsThatPassNearAPointAreMarked) {
  sim::Rng rng(4);
  for (int round = 0; round < 200; ++round) {
    const ScanGrid grid = round % 2 == 0 ? full_circle(360) : span_of(-1, 2, 0.01);
    const Raster raster(grid);
    const Point p = at(0.5 + 8 * rng.uniform(), 2 * pi_d * rng.uniform());
    const double reach = 0.02 + 0.3 * rng.uniform();
    std::vector<char> marks(grid.beams, 0);
    raster.mark_near(p, raster.position(p.x, p.y), static_cast<float>(reach), marks);
    for (std::size_t beam = 0; beam < grid.beams; ++beam) {
      const double off = std::abs(std::remainder(grid.angle(beam) - angle_of(p), 2 * pi_d));
      const double arc = reach / range_of(p);
      if (off < arc - 1e-4) {
        ASSERT_EQ(marks[beam], 1) << round << ' ' << off;
      }
      if (off > arc + 1.01 * grid.increment) {
        ASSERT_EQ(marks[beam], 0) << round << ' ' << off;
      }
    }
  }
  const ScanGrid grid = full_circle(360);
  std::vector<char> marks(360, 0);
  const Raster raster(grid);
  raster.mark_near(at(0.1, 0), raster.position(1, 0), 0.2F, marks);
  EXPECT_EQ(std::count(marks.begin(), marks.end(), 1), 360) << "the point is nearer than the reach";
}

}  // namespace
}  // namespace lidard
