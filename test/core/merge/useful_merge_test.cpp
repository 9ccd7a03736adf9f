// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// What merged scans must say although something is in the way, and which sources prove it.
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/angle.h"
#include "core/merge/merger.h"
#include "test/sim/world/circle.h"
#include "test/support/merge_score.h"

namespace lidard {
namespace {

constexpr double degree = rad_per_deg;

/// Two scanners at the front of a vehicle, merged in its middle.
struct Front {
  explicit Front(const std::vector<SourceSettings>& each = {}) {
    grid = test::full_circle(1440, 12);
    MergeSettings settings;
    settings.points = false;
    settings.visibility = true;
    settings.each = each;
    merger.emplace(grid, HeightBand{}, 2, settings);
    merger->set_footprint(Footprint({{-4, -1}, {0, -1}, {0, 1}, {-4, 1}}));
  }
  /// `change` may change the scan of scanner s.
  template <class Change>
  void sweep(Change change) {
    stamp = stamp + span_from_seconds(0.05);
    for (std::size_t s = 0; s < 2; ++s) {
      sim::FlatScanner scanner;
      scanner.at = {0, s == 0 ? 1.0 : -1.0};
      scanner.yaw = (s == 0 ? 45 : -45) * degree;
      scanner.increment = 0.5 * degree;
      scanner.field = 270 * degree;
      scanner.range_max = 20;
      PlanarScan scan;
      scanner.measure(world, rng, scan);
      change(s, scan);
      scan.stamp = stamp;
      ASSERT_TRUE(merger->add(s, scan, scanner.pose()));
    }
    merger->merge({stamp}, {1, 1}, {{Profile::strict, &strict}}, nullptr);
  }
  double free_ahead() const {
    std::size_t free = 0, all = 0;
    for (std::size_t i = 0; i < strict.beams; ++i) {
      if (std::fabs(grid.angle(i)) > 100 * degree) continue;
      ++all;
      free += strict.statuses[i] == BeamStatus::none ? 1 : 0;
    }
    return static_cast<double>(free) / static_cast<double>(all);
  }
  sim::FlatWorld world;
  sim::Rng rng{1};
  ScanGrid grid;
  std::optional<Merger> merger;
  Stamp stamp{1'700'000'000'000'000'000};
  PlanarScan strict;
};

TEST(UsefulMergedScan, DropsTakeLittleOfTheFreeSpace) {
  for (const auto& [share, wanted] : {std::pair(0.001, 0.98), {0.005, 0.98}, {0.02, 0.95}}) {
    Front front;
    for (int i = 0; i < 3; ++i) {
      front.sweep([&, share = share](std::size_t, PlanarScan& scan) {
        for (std::size_t b = 0; b < scan.beams; ++b)
          if (front.rng.uniform() < share)
            scan.set_hit(b, static_cast<float>(0.3 + 4.7 * front.rng.uniform()));
      });
      EXPECT_GE(front.free_ahead(), wanted) << share;
    }
  }
}

TEST(UsefulMergedScan, AReturnThatStaysIsNoDrop) {
  Front front;
  const auto rod = [](std::size_t s, PlanarScan& scan) {
    if (s == 0) scan.set_hit(270, 3);
  };
  front.sweep(rod);
  const auto& sweep = front.merger->last_sweep(0);
  ASSERT_EQ(sweep.lone_returns.size(), 1U);
  EXPECT_FALSE(sweep.lone_returns[0].thing);
  front.sweep(rod);
  EXPECT_TRUE(sweep.lone_returns[0].thing);
  front.sweep([](std::size_t, PlanarScan&) {});
  EXPECT_TRUE(sweep.lone_returns.empty());
}

TEST(UsefulMergedScan, WhatASourceSeesThatIsNotRequiredIsNotFreeButItsSurfacesCount) {
  std::vector<SourceSettings> each(2);
  each[1].proves_free = false;
  Front all, required(each);
  all.world.add_box({8, -6}, {0.5, 0.5}, 0);
  required.world = all.world;
  const auto nothing = [](std::size_t, PlanarScan&) {};
  all.sweep(nothing);
  required.sweep(nothing);
  // The left scanner sees nothing of what lies at right angles to the right.
  const std::size_t right = all.grid.nearest(-100 * degree), left = all.grid.nearest(60 * degree),
                    box = all.grid.nearest(std::atan2(-6, 8));
  EXPECT_EQ(all.strict.statuses[right], BeamStatus::none);
  EXPECT_EQ(required.strict.statuses[right], BeamStatus::invalid);
  EXPECT_EQ(required.strict.statuses[left], BeamStatus::none);
  EXPECT_EQ(required.strict.statuses[box], BeamStatus::hit);
}

}  // namespace
}  // namespace lidard
