// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/merge/cross_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/angle.h"
#include "test/sim/world/flat_world.h"
#include "test/sim/world/units.h"

namespace lidard {
namespace {

using sim::FlatScanner;
using sim::FlatWorld;

constexpr Stamp early{1'700'000'000'000'000'000};
constexpr Stamp later = early + std::chrono::milliseconds(20);

/// Scanners in a closed room whose sweeps are checked against each other.
class Room {
 public:
  explicit Room(const MergeOptions& options, std::vector<Eigen::Vector2d> places = {{0, 1}, {0, -1}},
                double noise = 0.005)
      : check(options, places.size(), 60, noise),
        noise_(noise),
        sweeps(places.size()),
        ends(places.size(), early) {
    world.add_box({0, 0}, {12, 9}, 0);
    for (const Eigen::Vector2d& place : places) {
      FlatScanner& scanner = scanners.emplace_back();
      scanner.at = place;
      scanner.field = 350 * degree;
      scanner.increment = degree;
      scanner.range_max = 60;
    }
  }
  /// Measures the room; then a return may be set to what is not there.
  void measure() {
    for (std::size_t s = 0; s < scanners.size(); ++s) {
      sim::Rng rng(1);
      scanners[s].measure(world, rng, scans.emplace_back());
    }
  }
  std::size_t beam_towards(std::size_t source, double angle) const {
    const PlanarScan& scan = scans[source];
    return static_cast<std::size_t>(
        std::lround((angle - scanners[source].yaw - static_cast<double>(scan.angle_min)) /
                    static_cast<double>(scan.angle_increment)));
  }
  void run() {
    if (scans.empty()) measure();
    SourceSettings settings;
    settings.noise = noise_;
    settings.veil_filter = false;
    for (std::size_t s = 0; s < scans.size(); ++s) {
      BeamRays rays;
      rays.build(scans[s], scanners[s].pose(), {}, {});
      check.set_source(s, rays);
      condition(scans[s], rays, settings, sweeps[s]);
      newest.push_back(&sweeps[s]);
    }
    before = sweeps;
    check.check(newest, ends);
  }

  CrossCheck check;
  double noise_;
  FlatWorld world;
  std::vector<FlatScanner> scanners;
  std::vector<PlanarScan> scans;
  std::vector<PlacedScan> sweeps, before;
  std::vector<Stamp> ends;
  std::vector<const PlacedScan*> newest;
};

MergeOptions doubting() {
  MergeOptions options;
  options.veil_cross_check = true;
  return options;
}

MergeOptions newest_wins() {
  MergeOptions options;
  options.newest_wins = true;
  return options;
}

std::size_t changed(const PlacedScan& before, const PlacedScan& after) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < before.kind.size(); ++i) count += before.kind[i] != after.kind[i] ? 1 : 0;
  return count;
}

TEST(CrossCheck, WhatEverybodySeesIsDoubtedByNobody) {
  for (const MergeOptions& options : {doubting(), newest_wins()}) {
    Room room(options, {{0, 1}, {0, -1}, {-3, 2}});
    room.world.add_box({4, 1}, {0.5, 0.7}, 0.4);
    room.ends = {early, later, early};
    room.run();
    for (std::size_t s = 0; s < 3; ++s) {
      EXPECT_EQ(changed(room.before[s], *room.newest[s]), 0U) << s;
      EXPECT_EQ(room.before[s].linked, room.newest[s]->linked) << s;
    }
    EXPECT_EQ(room.check.veils(), 0U);
    EXPECT_EQ(room.check.conflicts(), 0U);
  }
}

TEST(CrossCheck, AReturnThatAnotherSourceSeesThroughIsDoubtfulAndLinksToNothing) {
  for (const double towards : {5.0, 100.0, -60.0, -140.0}) {
    Room room(doubting());
    room.measure();
    const std::size_t beam = room.beam_towards(0, towards * degree);
    room.scans[0].set_hit(beam, 0.6F * room.scans[0].ranges[beam]);
    room.run();
    const PlacedScan& checked = *room.newest[0];
    EXPECT_NE(room.newest[0], &room.sweeps[0]) << "the sweep itself is left alone";
    EXPECT_EQ(room.sweeps[0].kind[beam], Return::surface);
    EXPECT_EQ(checked.kind[beam], Return::doubtful) << towards;
    EXPECT_EQ(checked.linked[beam], 0);
    EXPECT_EQ(checked.linked[beam - 1], 0);
    EXPECT_EQ(changed(room.before[0], checked), 1U) << towards;
    EXPECT_EQ(changed(room.before[1], *room.newest[1]), 0U) << towards;
    EXPECT_EQ(room.check.veils(), 1U);
    EXPECT_EQ(room.check.conflicts(), 0U);
  }
}

TEST(CrossCheck, AnySourceButItsOwnMayDoubtAReturn) {
  for (std::size_t wrong = 0; wrong < 3; ++wrong) {
    Room room(doubting(), {{0, 1}, {0, -1}, {-3, 2}});
    room.measure();
    const std::size_t beam = room.beam_towards(wrong, 20 * degree);
    room.scans[wrong].set_hit(beam, 5);
    room.run();
    for (std::size_t s = 0; s < 3; ++s)
      EXPECT_EQ(changed(room.before[s], *room.newest[s]), s == wrong ? 1U : 0U) << wrong << ' ' << s;
  }
}

/// Whether a return so far before a wall is doubted by a scanner that looks straight at the wall.
bool is_doubted(double before_wall, double noise) {
  Room room(doubting(), {{0, 0}, {0, 0.02}}, noise);
  room.measure();
  const std::size_t beam = room.beam_towards(0, 0);
  room.scans[0].set_hit(beam, static_cast<float>(12 - before_wall));
  room.run();
  return room.newest[0]->kind[beam] == Return::doubtful;
}

TEST(CrossCheck, ATenthOfAMetreOrFiveStandardDeviationsAreNobodysFault) {
  for (const double noise : {0.001, 0.019}) {
    EXPECT_FALSE(is_doubted(0.09, noise)) << noise;
    EXPECT_TRUE(is_doubted(0.12, noise)) << noise;
  }
  EXPECT_FALSE(is_doubted(0.19, 0.04));
  EXPECT_TRUE(is_doubted(0.22, 0.04));
  EXPECT_TRUE(is_doubted(6, 0.001));
}

TEST(CrossCheck, WhatIsSeenThroughAtItsEdgeAloneIsKept) {
  // A box that hides the wall from the second scanner beside the return: its edge may be as near as two
  // beams.
  for (const double beams_beside : {1.5, 3.5, -1.5, -3.5}) {
    Room room(doubting(), {{0, 0}, {0, 0.02}});
    const double hidden = (beams_beside > 0 ? beams_beside + 3 : beams_beside - 3) * degree;
    room.world.add_box(3 * Eigen::Vector2d(std::cos(hidden), std::sin(hidden)),
                       {0.01, 3 * std::tan(3 * degree)}, hidden);
    room.measure();
    const std::size_t beam = room.beam_towards(0, 0);
    room.scans[0].set_hit(beam, 7);
    room.run();
    const bool doubted = room.newest[0]->kind[beam] == Return::doubtful;
    EXPECT_EQ(doubted, std::abs(beams_beside) > 2) << beams_beside;
  }
}

TEST(CrossCheck, TheOlderReturnIsDroppedWhereTheNewestWinsAndNoOther) {
  for (const bool first_is_older : {true, false}) {
    for (const std::size_t wrong : {0U, 1U}) {
      Room room(newest_wins());
      room.measure();
      const std::size_t beam = room.beam_towards(wrong, 10 * degree);
      room.scans[wrong].set_hit(beam, 5);
      room.ends = {first_is_older ? early : later, first_is_older ? later : early};
      room.run();
      const bool older = (wrong == 0) == first_is_older;
      EXPECT_EQ(room.newest[wrong]->kind[beam], older ? Return::nothing : Return::surface);
      EXPECT_EQ(room.newest[wrong]->linked[beam], 0);
      EXPECT_EQ(room.check.conflicts(), older ? 1U : 0U);
      EXPECT_EQ(room.check.veils(), 0U);
    }
  }
  Room equal(newest_wins());
  equal.measure();
  equal.scans[0].set_hit(equal.beam_towards(0, 0.1), 5);
  equal.run();
  EXPECT_EQ(equal.check.conflicts(), 0U) << "neither is newer";
}

TEST(CrossCheck, WithBothOptionsTheOlderReturnGoesAndTheNewerOneIsDoubtful) {
  MergeOptions both = doubting();
  both.newest_wins = true;
  Room room(both);
  room.measure();
  const std::size_t older = room.beam_towards(0, 10 * degree), newer = room.beam_towards(1, -30 * degree);
  room.scans[0].set_hit(older, 5);
  room.scans[1].set_hit(newer, 5);
  room.ends = {early, later};
  room.run();
  EXPECT_EQ(room.newest[0]->kind[older], Return::nothing);
  EXPECT_EQ(room.newest[1]->kind[newer], Return::doubtful);
  EXPECT_EQ(room.check.conflicts(), 1U);
  EXPECT_EQ(room.check.veils(), 1U);
}

TEST(CrossCheck, AReturnThatWasDoubtfulAlreadyIsNotCountedAgain) {
  Room room(doubting());
  room.measure();
  const std::size_t beam = room.beam_towards(0, 10 * degree);
  room.scans[0].set_hit(beam, 5);
  room.run();
  room.sweeps[0].kind[beam] = Return::doubtful;
  room.newest = {&room.sweeps[0], &room.sweeps[1]};
  room.check.check(room.newest, room.ends);
  EXPECT_EQ(room.newest[0]->kind[beam], Return::doubtful);
  EXPECT_EQ(room.check.veils(), 1U);
}

TEST(CrossCheck, CornersOfADoubtfulReturnGoWithItAndOthersStay) {
  Room room(doubting(), {{0, 1}, {0, -1}});
  room.run();
  ASSERT_GE(room.before[0].corners.size(), 4U) << "the room has four";
  const std::size_t gone = room.before[0].corners.back().beam;
  room.sweeps = room.before;
  PlacedScan& sweep = room.sweeps[0];
  sweep.x[gone] *= 0.5F, sweep.y[gone] *= 0.5F;
  room.newest = {&room.sweeps[0], &room.sweeps[1]};
  room.check.check(room.newest, room.ends);
  std::vector<std::size_t> expected, kept;
  for (const PlacedScan::Corner& corner : room.before[0].corners) {
    if (corner.beam != gone && corner.beam + 1 != gone) expected.push_back(corner.beam);
  }
  for (const PlacedScan::Corner& corner : room.newest[0]->corners) kept.push_back(corner.beam);
  EXPECT_EQ(kept, expected);
  EXPECT_GE(kept.size(), 3U);
}

TEST(CrossCheck, ASourceWithoutSweepDoubtsNothingAndStaysWithout) {
  Room room(doubting());
  room.measure();
  const std::size_t beam = room.beam_towards(0, 10 * degree);
  room.scans[0].set_hit(beam, 5);
  room.run();
  ASSERT_EQ(room.newest[0]->kind[beam], Return::doubtful);
  room.newest = {&room.sweeps[0], nullptr};
  room.check.check(room.newest, room.ends);
  EXPECT_EQ(room.newest[1], nullptr);
  EXPECT_EQ(room.newest[0]->kind[beam], Return::surface) << "what the other one saw before is forgotten";
}

}  // namespace
}  // namespace lidard
