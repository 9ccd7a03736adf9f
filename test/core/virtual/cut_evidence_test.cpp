// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/virtual/cut_evidence.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/virtual/plane_cut.h"
#include "test/core/evidence/outline_bench.h"
#include "test/core/virtual/cut_bench.h"
#include "test/core/virtual/small_lidar.h"
#include "test/sim/world/units.h"

namespace lidard {
namespace {

using namespace test::rings;
using test::outline::free_pieces;
using test::outline::Piece;

/// A lidar that stands level, `above` m above a level plane (or beneath it), and what its beams prove of
/// that.
struct Scene {
  explicit Scene(std::uint64_t seed) : lidar(seed), grid(RingGridSettings{40, false}) {}

  void look(double above, HeightBand band = {0, 0}) { look_at(lidar.cloud(), above, band); }
  void look_at(const Cloud& seen, double above, HeightBand band = {0, 0}) {
    GroundSettings settings;
    settings.model = GroundModel::plane;
    cloud = seen;
    EXPECT_TRUE(grid.organise(cloud));
    // The lidar is 2 m above the ground.
    find_ground(grid, settings, make_pose({0, 0, 2}, {0, 0, 0}), ground);
    links.set(grid, 0.005);
    view.set_cloud(grid, ground, links, Eigen::Vector3f::UnitZ());
    view.set_frame(make_pose({0, 0, above}, {0, 0, 0}));
    view.set_level(0);
    tops.find(view);
    find(band);
  }
  void find(HeightBand band) {
    visibility.begin();
    evidence.find(view, tops, band, 0, visibility);
  }
  /// The pieces of one kind in the direction of a column.
  std::vector<Piece> pieces(std::size_t column, Visibility::Kind kind) {
    // A little aside, so that no vertex lies in that direction.
    const double angle = -lidar.azimuth(column) + 0.001 * grid.step();
    const Outlines& outlines = visibility.outlines(0, kind, grid.step(), 0);
    return free_pieces(outlines, outlines.source(), {0, 0}, angle);
  }

  SmallLidar lidar;
  Cloud cloud;
  RingGrid grid;
  Ground ground;
  RingLinks links;
  PlaneView view;
  PlaneTops tops;
  CutEvidence evidence;
  Visibility visibility{test::cut::full_circle(720), {}, 1};
};

/// What the beams of one column prove of a plane `above` m beneath the lidar (above it, if negative): the
/// rule as the header says it, beam by beam.
struct Proof {
  std::vector<Piece> free;
  double blind = 0;
};
Proof prove(const Scene& scene, std::size_t column, double above) {
  const auto rings = static_cast<int>(scene.grid.rings());
  const double sign = above > 0 ? 1 : -1;
  Proof proof;
  double begin = 0, last_at = 0, last_end = 0;
  bool crossed = false, last_on_ground = false, any = false;
  for (int k = 0; k < rings; ++k) {
    const int ring = sign > 0 ? k : rings - 1 - k;
    const std::size_t i = scene.grid.index(column, static_cast<std::size_t>(ring));
    const Beam kind = scene.grid.kind[i];
    const bool known = kind == Beam::point || kind == Beam::none;
    const BeamEnd& e = scene.grid.ends[i];
    const double end = std::hypot(static_cast<double>(e.x), static_cast<double>(e.y));
    const double drop = -sign * static_cast<double>(e.z);  // m from the lidar towards the plane
    const bool crosses = known && drop > std::abs(above);
    const double at = drop > 1e-9 ? end * std::abs(above) / drop : std::numeric_limits<double>::infinity();
    if (known && !any)
      proof.blind = drop <= 1e-6 ? 0 : crosses || kind == Beam::none ? at : std::min(at, end);
    any = any || known;
    if (crosses) {
      if (!crossed) begin = at;
      crossed = true;
      last_at = at, last_end = end;
      last_on_ground = kind == Beam::none || scene.ground.is_ground[i] != 0;
      continue;
    }
    if (crossed) {
      // Up to what the next beam meets; what the last one met beyond the plane may stand in the plane too.
      double to = !known ? last_at : last_on_ground ? end : std::max(last_at, std::min(last_end, end));
      proof.free.push_back({begin, to});
      crossed = false;
    }
  }
  if (crossed) proof.free.push_back({begin, last_at});
  return proof;
}

/// The columns on either side cross the plane with the same rings and meet the same surface, as far as
/// anything is known of them.
bool neighbours_agree(const Scene& scene, std::size_t column, double above) {
  const auto crosses = [&](std::size_t c, std::size_t ring) {
    const auto z = static_cast<double>(scene.grid.ends[scene.grid.index(c % 360, ring)].z);
    return above > 0 ? z < -above : z > -above;
  };
  const auto known = [&](std::size_t c, std::size_t ring) {
    const Beam kind = scene.grid.kind[scene.grid.index(c % 360, ring)];
    return kind == Beam::point || kind == Beam::none;
  };
  for (std::size_t ring = 0; ring < scene.grid.rings(); ++ring) {
    for (const std::size_t beside : {column + 359, column + 1}) {
      const bool both = known(column, ring) && known(beside, ring);
      if (both && crosses(column, ring) != crosses(beside, ring)) return false;
      const std::size_t first = beside > column ? column : beside % 360;
      if (both && !scene.links.level(first, ring)) return false;
    }
  }
  return true;
}

void expect_proof(Scene& scene, const Proof& proof, std::size_t column) {
  std::vector<Piece> expected;
  for (const Piece& piece : proof.free) {
    if (std::abs(piece.to - piece.from) < 0.003) return;  // one beam alone proves a point
    if (piece.to > piece.from) expected.push_back(piece);
  }
  const std::vector<Piece> pieces = scene.pieces(column, Visibility::seen);
  ASSERT_EQ(pieces.size(), expected.size()) << column;
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    // The neighbours may meet a slanting wall a little nearer or farther.
    ASSERT_NEAR(pieces[p].from, expected[p].from, 0.003 + 1e-3 * expected[p].from)
        << column << " piece " << p;
    ASSERT_NEAR(pieces[p].to, expected[p].to, 0.003 + 1e-3 * expected[p].to) << column << " piece " << p;
  }
  const std::vector<Piece> blind = scene.pieces(column, Visibility::blind);
  ASSERT_EQ(blind.empty(), proof.blind <= 0) << column;
  if (proof.blind <= 0) return;
  ASSERT_NEAR(blind[0].to, proof.blind, 0.003 + 1e-3 * proof.blind) << column;
}

TEST(CutEvidence, ThePlaneIsFreeBetweenTheBeamsThatCrossItAndBlindBeforeThem) {
  std::size_t split = 0, blind = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Scene scene(seed);
    scene.lidar.elevations = {-0.5, -0.4, -0.3, -0.2, -0.15, -0.1, 0.02, 0.1};
    scene.lidar.offsets.assign(8, 0);
    // Beams end on the ground, 2 m beneath, or at a wall; some were lost.
    scene.lidar.range = [&](std::size_t ring, std::size_t column) {
      const double e = scene.lidar.elevations[ring];
      const double wall = (12 + 3 * std::sin(0.1 * static_cast<double>(column))) / std::cos(e);
      return e < 0 ? std::min(wall, 2 / std::sin(-e)) : wall;
    };
    scene.look(1.5);
    // Beams that nothing is known of.
    for (std::size_t i = 0; i < scene.grid.kind.size(); ++i) {
      if (scene.lidar.rng.uniform() < 0.15) scene.grid.kind[i] = Beam::unknown;
    }
    scene.view.set_cloud(scene.grid, scene.ground, scene.links, Eigen::Vector3f::UnitZ());
    scene.view.set_frame(make_pose({0, 0, 1.5}, {0, 0, 0}));
    scene.view.set_level(0);
    scene.tops.find(scene.view);
    scene.find({0, 0});
    for (std::size_t c = 0; c < 360; ++c) {
      const Proof proof = prove(scene, c, 1.5);
      if (proof.free.size() > 2 || !neighbours_agree(scene, c, 1.5)) continue;
      expect_proof(scene, proof, c);
      if (HasFatalFailure()) return;
      split += proof.free.size() == 2 ? 1 : 0;
      blind += proof.blind > 3.5 ? 1 : 0;
    }
  }
  EXPECT_GT(split, 100U);
  EXPECT_GT(blind, 20U);
}

TEST(CutEvidence, APlaneAboveTheLidarIsSeenFromBeneath) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Scene scene(seed);
    scene.lidar.elevations = {-0.1, -0.02, 0.1, 0.2, 0.3, 0.4};
    scene.lidar.offsets.assign(6, 0);
    // Upward nothing comes back; the lowest beams meet something.
    scene.lidar.range = [&](std::size_t ring, std::size_t column) {
      return ring < 2 || column % 40 == 0 ? 6 + 2 * std::sin(0.1 * static_cast<double>(column)) : 0.0;
    };
    scene.look(-1.2);
    for (std::size_t c = 0; c < 360; ++c) {
      if (c % 40 == 0 || !neighbours_agree(scene, c, -1.2)) continue;
      expect_proof(scene, prove(scene, c, -1.2), c);
      if (HasFatalFailure()) return;
    }
  }
}

TEST(CutEvidence, OfABandFreePiecesEndWhereSomethingStandsInIt) {
  Scene scene(2);
  scene.lidar.elevations = {-0.4, -0.3, -0.2, -0.1, 0.02};
  scene.lidar.offsets.assign(5, 0);
  scene.lidar.range = [&](std::size_t ring, std::size_t column) {
    const double e = scene.lidar.elevations[ring];
    // A rail that only the beam at -0.1 rad meets, 0.9 m beneath the lidar.
    if (ring == 3 && column >= 100 && column < 150) return 9 / std::cos(e);
    return e < 0 ? std::min(15 / std::cos(e), 2 / std::sin(-e)) : 15 / std::cos(e);
  };
  // The plane lies 1.5 m beneath; the band reaches from there to 1 m above it.
  scene.look(1.5, {0, 1});
  for (const std::size_t column : {110U, 130U, 145U}) {
    const std::vector<Piece> pieces = scene.pieces(column, Visibility::seen);
    ASSERT_FALSE(pieces.empty()) << column;
    EXPECT_NEAR(pieces[0].to, 9, 0.01) << column;
  }
  for (const std::size_t column : {50U, 200U, 300U})
    EXPECT_NEAR(scene.pieces(column, Visibility::seen)[0].to, 15, 0.01);
}

/// A slope between two rings that leans away: the lower returns at 8 m, the upper ones at 9 m.
struct Slope {
  explicit Slope(HeightBand band, bool apart = false) : scene(1) {
    scene.lidar.elevations = {-0.1, 0.02, 0.3};
    scene.lidar.offsets = {0, 0.4 * scene.lidar.step(), 0};  // the lines run a little across the beams
    scene.lidar.range = [apart](std::size_t ring, std::size_t column) {
      if (apart && column % 8 != 0) return column % 8 == 4 && ring == 2 ? 30.0 : 0.0;
      return ring == 0 ? 8.0 : ring == 1 ? (apart ? 25.0 : 9.0) : 0.0;
    };
    scene.look(1);  // the frame is 1 m beneath the lidar
    ScanGridSpec spec;
    spec.beams = 28800;
    grid = make_grid(spec).value();
    const Raster raster(grid);
    layer.clear(grid.beams);
    PlaneCut().draw_edges(scene.view, band, raster, layer);
  }
  /// The nearest and the farthest that is drawn within a quarter of a degree of a column.
  Piece drawn(std::size_t column) const {
    const std::size_t middle = grid.nearest(-scene.lidar.azimuth(column)) + grid.beams;
    Piece found{infinite, -infinite};
    for (std::size_t beam = middle - 35; beam <= middle + 35; ++beam) {
      const auto range = static_cast<double>(layer.range[beam % grid.beams]);
      if (std::isinf(range)) continue;
      found = {std::min(found.from, range), std::max(found.to, range)};
    }
    return found;
  }
  Scene scene;
  ScanGrid grid;
  RangeLayer layer;
};

TEST(BandEdges, OfALineBetweenTwoReturnsThePartInTheBandCounts) {
  const double z0 = 1 + 8 * std::sin(-0.1), r0 = 8 * std::cos(-0.1);
  const double z1 = 1 + 9 * std::sin(0.02), r1 = 9 * std::cos(0.02);
  const auto range_at = [&](double z) { return r0 + (z - z0) / (z1 - z0) * (r1 - r0); };
  for (const HeightBand& band : {HeightBand{0, 3}, HeightBand{0.4, 0.9}, HeightBand{0.5, 0.7},
                                 HeightBand{1, 5}, HeightBand{-1, 0.4}}) {
    const Slope slope(band);
    for (const std::size_t column : {3U, 77U, 180U, 359U}) {
      const Piece drawn = slope.drawn(column);
      EXPECT_NEAR(drawn.from, range_at(std::max(band.min, z0)), 0.04) << band.min;
      if (band.min > z0 && band.max < z1) {
        EXPECT_NEAR(drawn.to, range_at(band.max), 0.04) << band.max;
      }
    }
  }
  for (const HeightBand& band : {HeightBand{1.3, 3}, HeightBand{-2, 0.1}}) {
    const Slope slope(band);
    for (const float range : slope.layer.range) EXPECT_TRUE(std::isinf(range)) << band.min;
  }
}

TEST(BandEdges, AReturnThatStandsAloneCountsIfItIsInTheBand) {
  const double z = 1 + 8 * std::sin(-0.1);
  for (const bool inside : {true, false}) {
    const Slope alone(inside ? HeightBand{z - 0.01, z + 0.01} : HeightBand{z + 0.01, z + 0.3}, true);
    std::size_t all = 0;
    for (const float range : alone.layer.range) {
      if (std::isinf(range)) continue;
      EXPECT_NEAR(range, 8 * std::cos(-0.1), 0.01);
      ++all;
    }
    EXPECT_EQ(all, inside ? 45U : 0U) << "each in one beam";
    for (std::size_t column = 0; column < 360; column += 8) {
      EXPECT_EQ(alone.drawn(column).from < 9, inside) << column;
    }
  }
}

/// What a lidar sees in a square of walls.
Cloud walled(const std::vector<double>& elevations) {
  sim::Yard yard;
  for (const double side : {-8.0, 8.0}) {
    yard.objects.push_back(test::cut::wall(side, -8, side, 8, 20));
    yard.objects.push_back(test::cut::wall(-8, side, 8, side, 20));
  }
  sim::YardLidar lidar = test::cut::lidar16();
  lidar.elevations = elevations;
  return test::cut::seen(yard, lidar);
}

TEST(CutEvidence, DrawsAWallThatManyRingsMeetOnce) {
  Scene scene(1);
  const Cloud cloud = walled(sim::even_rings(16, -15, 15));
  for (double above = 1.8; above > -3; above -= 0.3) {
    scene.look_at(cloud, above);
    EXPECT_LT(scene.visibility.outlines(0, Visibility::seen, 1, 0).edges.size(), 4 * scene.grid.columns())
        << above;
  }
}

TEST(CutEvidence, EndsWithinReachWhateverThePlane) {
  Scene scene(1);
  for (const auto& elevations : {sim::even_rings(16, -15, 15), sim::even_rings(16, -30, -2),
                                 sim::even_rings(10, -90, 0), sim::even_rings(10, 0, 90)}) {
    const Cloud cloud = walled(elevations);
    for (const double above : {2.0, 0.5, 1e-3, 1e-6, 0.0, -1e-6, -0.5}) {
      for (const HeightBand band : {HeightBand{0, 0}, HeightBand{-above - 1, 1.0 - above}}) {
        scene.look_at(cloud, above, band);
        const Outlines& outlines = scene.visibility.outlines(0, Visibility::seen, 1, 0);
        for (std::size_t i = 0; i < outlines.x.size(); ++i)
          ASSERT_LT(std::hypot(outlines.x[i], outlines.y[i]), 1000) << above << ' ' << i;
      }
    }
  }
}

}  // namespace
}  // namespace lidard
