// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/base/angle.h"
#include "core/merge/merger.h"
#include "test/core/evidence/outline_bench.h"
#include "test/sim/world/circle.h"
#include "test/sim/world/rng.h"

namespace lidard {
namespace {

using test::outline::add_ring;
using test::outline::free_pieces;
using test::outline::Piece;

constexpr Stamp now{1'700'000'000'000'000'000};

/// What one of several scanners in one place measures of a round wall.
struct View {
  float range, intensity;
};

PlanarScan merged(const std::vector<View>& views, double range_max = 50) {
  MergeSettings settings;
  settings.points = false;
  settings.visibility = true;
  settings.how.noise = settings.source.noise = 0.02;
  Merger merger(test::full_circle(360, range_max), {}, views.size(), settings);
  std::vector<char> use;
  for (std::size_t s = 0; s < views.size(); ++s) {
    PlanarScan scan;
    scan.reset(720, 1, true);
    scan.set_angles(static_cast<float>(-pi_d), static_cast<float>(pi_d / 360));
    scan.range_max = 60;
    scan.stamp = now;
    for (std::size_t i = 0; i < 720; ++i) {
      scan.set_hit(i, views[s].range);
      scan.intensities[i] = views[s].intensity;
    }
    EXPECT_TRUE(merger.add(s, scan, Pose::Identity()));
    use.push_back(1);
  }
  PlanarScan out;
  merger.merge({now}, use, {{Profile::strict, &out}}, nullptr);
  EXPECT_EQ(violation(out), nullptr);
  return out;
}

void expect_everywhere(const PlanarScan& scan, double range, double intensity) {
  for (std::size_t i = 1; i + 1 < scan.beams; ++i) {
    ASSERT_EQ(scan.statuses[i], BeamStatus::hit) << i;
    ASSERT_NEAR(static_cast<double>(scan.ranges[i]), range, 1e-3) << i;
    ASSERT_NEAR(static_cast<double>(scan.intensities[i]), intensity, 1e-3) << i;
  }
}

TEST(VisibilityGaps, OfSeveralSourcesTheNearestCountsWithItsOwnIntensity) {
  expect_everywhere(merged({{5, 100}, {5.04F, 160}}), 5, 100);
  expect_everywhere(merged({{5.04F, 160}, {5, 100}}), 5, 100);
}

TEST(VisibilityGaps, BeyondTheRangeOfTheOutputThereIsNothing) {
  const PlanarScan scan = merged({{35, 100}, {35.02F, 50}}, 20);
  for (std::size_t i = 1; i + 1 < scan.beams; ++i) EXPECT_EQ(scan.statuses[i], BeamStatus::none) << i;
}

/// A scanner in the origin of the output with a surface 20 m away; the way is free from `from` to `to`, m.
class Alone {
 public:
  explicit Alone(double from, double to, const VisibilitySettings& how) {
    const ScanGrid grid = test::full_circle(360, 30);
    Visibility visibility(grid, how, 1);
    visibility.begin();
    add_ring(visibility, {0, 0}, std::vector<Piece>(3600, {from, to}));
    for (float& range : visibility.surfaces().range) range = 20;
    visibility.compute();
    state = visibility.state(77);
    covered = static_cast<double>(visibility.covered(77));
  }
  BeamState state;
  double covered;
};

TEST(VisibilityGaps, AsMuchOfTheWayAsIsAllowedMayGoUnseenAndNoMore) {
  VisibilitySettings how;
  how.gap = 0.5;
  how.gap_share = 0;
  EXPECT_EQ(Alone(0, 25, how).state, BeamState::hit);
  EXPECT_EQ(Alone(0.3, 25, how).state, BeamState::hit);
  EXPECT_EQ(Alone(0.8, 25, how).state, BeamState::gap);
  EXPECT_LT(Alone(0.8, 25, how).covered, 0.6);
  EXPECT_EQ(Alone(0, 10, how).state, BeamState::gap);
  EXPECT_NEAR(Alone(0, 10, how).covered, 10, 0.5);
  how.gap_share = 0.2;
  EXPECT_EQ(Alone(0, 17, how).state, BeamState::behind) << "a fifth of 20 m, but its very end is not seen";
  EXPECT_EQ(Alone(0, 10, how).state, BeamState::gap);
}

TEST(VisibilityGaps, ASurfaceIsSeenFromTheSideWhereTheLastOfTheWayIsFree) {
  VisibilitySettings how;
  how.gap = 1;
  how.approach = 0.5;
  EXPECT_EQ(Alone(0, 19.6, how).state, BeamState::hit);
  EXPECT_EQ(Alone(0, 19.4, how).state, BeamState::behind);
  how.noise = 0.2;
  EXPECT_EQ(Alone(0, 19.1, how).state, BeamState::hit) << "five standard deviations before it";
  EXPECT_EQ(Alone(0, 18.9, how).state, BeamState::behind);
}

TEST(VisibilityGaps, ABeamThatPassesASourceNearerThanThatOneSeesIsNotFree) {
  const ScanGrid grid = test::full_circle(360, 10);
  for (double ahead = 1; ahead < 3; ahead += 0.02) {
    Visibility visibility(grid, {}, 1);
    visibility.begin();
    add_ring(visibility, {ahead, 0.15}, std::vector<Piece>(360, {0.3, 15}));
    visibility.compute();
    EXPECT_EQ(visibility.state(180), BeamState::unobserved) << ahead;
    EXPECT_LT(static_cast<double>(visibility.covered(180)), ahead - 0.24) << ahead;
    EXPECT_EQ(visibility.state(90), BeamState::free) << "it leads away from the source";
  }
}

/// Free space that is cut up at random: runs of beams that see far, to some distance, or from some distance
/// on.
std::vector<Piece> random_pieces(sim::Rng& rng) {
  std::vector<Piece> pieces(360);
  for (std::size_t i = 0; i < pieces.size();) {
    const double kind = rng.uniform(), far = kind < 0.6 ? 15 : 8 * rng.uniform();
    const double from = kind > 0.9 ? far * rng.uniform() : 0;
    const std::size_t end = std::min(pieces.size(), i + 1 + static_cast<std::size_t>(60 * rng.uniform()));
    for (; i < end; ++i) pieces[i] = {from, far};
  }
  return pieces;
}

TEST(VisibilityGaps, EveryPointOfAFreeBeamIsSeenBySomeSource) {
  sim::Rng rng(9);
  const ScanGrid grid = test::full_circle(360, 6);
  std::size_t free = 0;
  for (int round = 0; round < 100; ++round) {
    Visibility visibility(grid, {}, 3);
    visibility.begin();
    for (std::size_t source = 0; source < 3; ++source)
      add_ring(visibility, {rng.within(3), rng.within(3)}, random_pieces(rng), source);
    visibility.compute();
    const Outlines& outlines = visibility.outlines(0, Visibility::seen, 1, 0);
    for (std::size_t beam = 0; beam < visibility.beams(); ++beam) {
      if (visibility.state(beam) != BeamState::free) continue;
      ++free;
      // By each source alone, in turn from the end of what the others see.
      double known = 0;
      for (std::size_t asked = 0; asked < 3; ++asked) {
        for (std::size_t source = 0; source < 3; ++source) {
          for (const Piece& piece : free_pieces(outlines, source, {0, 0}, grid.angle(beam)))
            if (piece.from <= known + 0.004) known = std::max(known, piece.to);
        }
      }
      EXPECT_GE(known, 5.99) << round << ' ' << beam;
    }
  }
  EXPECT_GT(free, 2000U);
}

}  // namespace
}  // namespace lidard
