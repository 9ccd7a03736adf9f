// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/evidence/visibility.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/angle.h"
#include "test/sim/world/flat_world.h"
#include "test/sim/world/units.h"
#include "test/support/allocations.h"

namespace lidard {
namespace {

using sim::FlatScanner;
using sim::FlatWorld;

ScanGrid grid_of(std::size_t beams, double range_max = 24) {
  ScanGridSpec spec;
  spec.beams = beams;
  spec.range_max = range_max;
  return make_grid(spec).value();
}

/// The vehicle of the paper on ira_laser_tools: scanners A and B on the front corners of a body of 4 x 2 m,
/// the output midway between them; a room of 40 x 24 m, a box 2 m ahead.
struct Paper {
  explicit Paper(double source_deg, double turn = 0) {
    FlatWorld level;
    level.add_box({0, 0}, {20, 12}, 0);
    level.add_box({2.5, 0}, {0.5, 0.5}, 0);
    world = level.seen_from({0, 0}, -turn);
    for (const double side : {1.0, -1.0}) {
      FlatScanner scanner;
      scanner.at = Eigen::Rotation2Dd(turn) * Eigen::Vector2d(0, side);
      scanner.yaw = turn + side * pi_d / 4;
      scanner.increment = source_deg * degree;
      scanner.range_max = 60;
      scanners.push_back(scanner);
    }
    body = Footprint({{-4, -1}, {0, -1}, {0, 1}, {-4, 1}}).transformed(make_pose({0, 0, 0}, {0, 0, turn}));
  }

  FlatWorld world;
  std::vector<FlatScanner> scanners;
  Footprint body;
};

/// Runs scanners through conditioning and merging.
class Merged {
 public:
  Merged(const Paper& paper, const ScanGrid& grid, VisibilitySettings settings = {})
      : visibility_(grid, settings, paper.scanners.size()), sweeps_(paper.scanners.size()) {
    visibility_.set_footprint(paper.body);
    for (const FlatScanner& scanner : paper.scanners) {
      sim::Rng rng(1);
      scanner.measure(paper.world, rng, scans_.emplace_back());
      rays_.emplace_back().build(scans_.back(), scanner.pose(), paper.body, {});
      visibility_.set_source(rays_.size() - 1, rays_.back());
    }
    SourceSettings source;
    source.noise = 0.001;
    for (std::size_t s = 0; s < scans_.size(); ++s) {
      condition(scans_[s], rays_[s], source, sweeps_[s]);
      newest_.push_back(&sweeps_[s]);
    }
  }
  void without(std::size_t source) { newest_[source] = nullptr; }
  const PlanarScan& scan(Profile profile) {
    visibility_.compute(newest_);
    visibility_.encode(profile, scan_, false);
    return scan_;
  }
  const Visibility& visibility() const { return visibility_; }

 private:
  Visibility visibility_;
  std::vector<PlanarScan> scans_;
  std::vector<BeamRays> rays_;
  std::vector<PlacedScan> sweeps_;
  std::vector<const PlacedScan*> newest_;
  PlanarScan scan_;
};

double degrees_from(double angle, double direction) {
  return std::abs(std::remainder(angle - direction, 2 * pi_d)) / degree;
}

TEST(Visibility, NoBeamSeesThroughTheBoxNearTheVehicleAndEveryRangeIsExact) {
  for (const double source : {0.25, 0.5, 1.0}) {
    for (const std::size_t beams : {720U, 1440U}) {
      const Paper paper(source);
      Merged merged(paper, grid_of(beams, 50));
      const PlanarScan& scan = merged.scan(Profile::strict);
      EXPECT_EQ(violation(scan), nullptr);
      for (std::size_t i = 0; i < beams; ++i) {
        const double angle = grid_of(beams).angle(i);
        if (degrees_from(angle, 0) > 13.5) continue;
        ASSERT_EQ(scan.statuses[i], BeamStatus::hit) << source << ' ' << beams << ' ' << angle;
        EXPECT_NEAR(scan.ranges[i], 2 / std::cos(angle), 0.001) << source << ' ' << beams << ' ' << angle;
      }
    }
  }
}

TEST(Visibility, EveryClaimOnTheWallsAndTheBoxIsExact) {
  const Paper paper(0.5);
  Merged merged(paper, grid_of(1440, 50));
  const PlanarScan& scan = merged.scan(Profile::strict);
  int hits = 0;
  for (std::size_t i = 0; i < scan.beams; ++i) {
    if (scan.statuses[i] != BeamStatus::hit) continue;
    ++hits;
    const double angle = grid_of(1440).angle(i);
    double best = 1e9;
    for (const double side : {0.0, -0.5, 0.5}) {
      const double truth = paper.world.cast({0, 0}, angle + side * 2 * pi_d / 1440);
      best = std::min(best, std::abs(truth - static_cast<double>(scan.ranges[i])));
    }
    // Across a corner of the room the chord between two beams cuts a little off.
    EXPECT_LT(best, 0.1) << angle / degree;
  }
  EXPECT_GT(hits, 1200);
}

TEST(Visibility, StripBehindTheVehicleIsNotClaimed) {
  for (const std::size_t beams : {720U, 1440U}) {
    Paper paper(0.5);
    paper.world.add_box({-8, 0}, {0.2, 0.2}, 0);
    Merged merged(paper, grid_of(beams, 50));
    const PlanarScan& scan = merged.scan(Profile::strict);
    int claimed = 0;
    for (std::size_t i = 0; i < beams; ++i) {
      const double from_rear = degrees_from(grid_of(beams).angle(i), pi_d);
      if (from_rear <= 12.5) {
        EXPECT_EQ(scan.statuses[i], BeamStatus::invalid) << from_rear;
      }
      if (from_rear > 14.6 && from_rear < 60) claimed += scan.statuses[i] == BeamStatus::hit ? 1 : 0;
    }
    EXPECT_GT(claimed, static_cast<int>(beams) / 5);
  }
}

TEST(Visibility, TurningTheWholeSceneTurnsTheScan) {
  Merged level(Paper(0.5), grid_of(1440, 50));
  Merged turned(Paper(0.5, pi_d), grid_of(1440, 50));
  const PlanarScan a = level.scan(Profile::strict);
  const PlanarScan& b = turned.scan(Profile::strict);
  for (std::size_t i = 0; i < 1440; ++i) {
    const std::size_t j = (i + 720) % 1440;
    ASSERT_EQ(a.statuses[i], b.statuses[j]) << i;
    if (a.statuses[i] == BeamStatus::hit) {
      EXPECT_NEAR(a.ranges[i], b.ranges[j], 1e-3) << i;
    }
  }
}

TEST(Visibility, ThinPoleIsNotSeenThrough) {
  // 6 cm wide, seen by beams of 1 degree; from the output's origin it is four to five beams of a quarter of a
  // degree wide.
  Paper paper(1);
  paper.world.add_box({1, -3}, {0.03, 0.03}, 0);
  Merged merged(paper, grid_of(1440, 50));
  const PlanarScan& scan = merged.scan(Profile::safety);
  int on_pole = 0;
  for (std::size_t i = 0; i < scan.beams; ++i) {
    const bool towards = degrees_from(grid_of(1440).angle(i), std::atan2(-3, 1)) < 1;
    if (towards && scan.statuses[i] == BeamStatus::hit && std::abs(scan.ranges[i] - 3.16F) < 0.1F) ++on_pole;
  }
  EXPECT_GE(on_pole, 4);
}

TEST(Visibility, OrderOfTheSourcesChangesNothing) {
  Paper paper(0.5);
  Merged one(paper, grid_of(1440, 50));
  std::swap(paper.scanners[0], paper.scanners[1]);
  Merged other(paper, grid_of(1440, 50));
  for (const Profile profile : {Profile::strict, Profile::safety}) {
    const PlanarScan& a = one.scan(profile);
    const PlanarScan& b = other.scan(profile);
    EXPECT_EQ(a.statuses, b.statuses);
    for (std::size_t i = 0; i < a.beams; ++i) {
      if (a.statuses[i] == BeamStatus::hit) {
        EXPECT_EQ(a.ranges[i], b.ranges[i]) << i;
      }
    }
  }
}

TEST(Visibility, WithoutAnySourceEverythingIsUnknown) {
  Visibility visibility(grid_of(360), {}, 0);
  visibility.compute({});
  PlanarScan scan;
  for (const Profile profile : {Profile::strict, Profile::safety}) {
    visibility.encode(profile, scan, false);
    EXPECT_EQ(violation(scan), nullptr);
    EXPECT_EQ(std::count(scan.statuses.begin(), scan.statuses.end(), BeamStatus::invalid), 360);
  }
}

TEST(Visibility, OpenFieldIsFreeButForTheBlindCone) {
  Paper paper(0.5);
  paper.world = FlatWorld();
  Merged merged(paper, grid_of(720, 50));
  const PlanarScan& scan = merged.scan(Profile::strict);
  for (std::size_t i = 0; i < scan.beams; ++i) {
    const double from_rear = degrees_from(grid_of(720).angle(i), pi_d);
    if (from_rear <= 12.5) {
      EXPECT_EQ(scan.statuses[i], BeamStatus::invalid) << from_rear;
    }
    if (from_rear >= 14.6) {
      EXPECT_EQ(scan.statuses[i], BeamStatus::none) << from_rear;
    }
  }
}

TEST(Visibility, WayOutOfReachOfEveryScannerIsNotFree) {
  Paper paper(0.5);
  paper.world = FlatWorld();
  for (FlatScanner& scanner : paper.scanners) scanner.range_max = 24;
  Merged merged(paper, grid_of(720, 30));
  const PlanarScan& scan = merged.scan(Profile::safety);
  EXPECT_EQ(std::count(scan.statuses.begin(), scan.statuses.end(), BeamStatus::none), 0);
  EXPECT_NEAR(merged.visibility().covered(360), 24, 0.5);
}

TEST(Visibility, FreeNeedsProofToRangeMaxUnlessLessIsAskedFor) {
  Paper paper(0.5);
  paper.world = FlatWorld();
  for (FlatScanner& scanner : paper.scanners) scanner.range_max = 24;
  const auto ahead = [&](double free_required) {
    VisibilitySettings settings;
    settings.free_required = free_required;
    Merged merged(paper, grid_of(720, 24), settings);
    return merged.scan(Profile::strict).statuses[360];
  };
  // Straight ahead the end of 24 m is a little farther than that from both scanners beside the origin.
  EXPECT_EQ(ahead(0), BeamStatus::invalid);
  EXPECT_EQ(ahead(24), BeamStatus::invalid);
  EXPECT_EQ(ahead(23), BeamStatus::none);
}

TEST(Visibility, ItIsKnownToAStepHowFarAWayIsFree) {
  // Steps are 0.12 m, or 2.5 % of the range; distances are known to 3 mm.
  Paper paper(0.5);
  paper.world = FlatWorld();
  for (FlatScanner& scanner : paper.scanners) scanner.at = {0, 0};
  double worst_near = 0, worst_far = 0;
  for (double reach = 1; reach < 12; reach *= 1.013) {
    for (FlatScanner& scanner : paper.scanners) scanner.range_max = reach;
    Merged merged(paper, grid_of(36, 24));
    merged.scan(Profile::strict);
    const double covered = static_cast<double>(merged.visibility().covered(18));  // straight ahead
    EXPECT_LE(covered, reach + 0.001);
    double& worst = reach < 4.8 ? worst_near : worst_far;
    worst = std::max(worst, (reach - covered) / (reach < 4.8 ? 1 : reach));
  }
  EXPECT_LT(worst_near, 0.1235);
  EXPECT_LT(worst_far, 0.0258);
}

TEST(Visibility, SectorOfAMissingScannerIsUnknownNotFree) {
  const Paper paper(0.5);
  Merged merged(paper, grid_of(720, 50));
  merged.without(0);
  const PlanarScan& scan = merged.scan(Profile::safety);
  for (std::size_t i = 0; i < scan.beams; ++i) {
    EXPECT_NE(scan.statuses[i], BeamStatus::none);
    const double angle = grid_of(720).angle(i);
    // What lies left of the body only A could see.
    if (angle > 120 * degree && angle < 160 * degree) {
      EXPECT_EQ(scan.statuses[i], BeamStatus::invalid) << angle;
    }
  }
  merged.without(1);
  const PlanarScan& none = merged.scan(Profile::safety);
  EXPECT_EQ(std::count(none.statuses.begin(), none.statuses.end(), BeamStatus::invalid), 720);
}

TEST(Visibility, OfAWallSeenFromBehindAloneNothingIsSaid) {
  // The scanner stands behind a wall and sees its far side; the output's origin is in front of it.
  Paper paper(0.5);
  paper.world = FlatWorld();
  paper.world.add_wall({3, -2}, {3, 2});
  paper.scanners.resize(1);
  paper.scanners[0].at = {6, 0};
  paper.scanners[0].yaw = pi_d;
  paper.body = Footprint();
  Merged merged(paper, grid_of(720, 30));
  EXPECT_EQ(merged.scan(Profile::strict).statuses[360], BeamStatus::invalid);
  EXPECT_NE(merged.visibility().state(360), BeamState::hit);
  const PlanarScan& safety = merged.scan(Profile::safety);
  EXPECT_EQ(safety.statuses[360], BeamStatus::invalid) << "what it is the back of may be thick";
}

TEST(Visibility, OriginThatNoScannerSeesMakesNoClaims) {
  for (const Eigen::Vector2d& away : {Eigen::Vector2d(2.5, 0), Eigen::Vector2d(50, 30)}) {
    Paper paper(0.5);
    paper.world = paper.world.seen_from(away, 0);
    for (FlatScanner& scanner : paper.scanners) scanner.at -= away;
    paper.body = Footprint();
    Merged merged(paper, grid_of(720, 50));
    const PlanarScan& scan = merged.scan(Profile::strict);
    EXPECT_EQ(std::count(scan.statuses.begin(), scan.statuses.end(), BeamStatus::none), 0);
    EXPECT_EQ(std::count(scan.statuses.begin(), scan.statuses.end(), BeamStatus::hit), 0) << away.transpose();
  }
}

TEST(Visibility, MergesWithoutAllocatingAfterTheFirstTime) {
  const Paper paper(0.25);
  Merged merged(paper, grid_of(1440, 50));
  merged.scan(Profile::strict);
  merged.scan(Profile::safety);
  const std::uint64_t before = test::allocations();
  for (int i = 0; i < 5; ++i) {
    merged.scan(Profile::strict);
    merged.scan(Profile::safety);
  }
  EXPECT_EQ(test::allocations(), before);
}

}  // namespace
}  // namespace lidard
