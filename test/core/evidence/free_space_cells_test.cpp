// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/base/angle.h"
#include "core/evidence/free_space_map.h"
#include "test/sim/world/rng.h"

namespace lidard {
namespace {

TEST(FreeSpaceMap, AClaimIsRoundedInwardsAndReplacesTheOneBefore) {
  FreeSpaceMap map;
  map.set(0, 0, rad_per_deg, 0.25);
  map.claim(3, 1.1F, 2.9F);
  const auto& cell = map.runs()[3];
  for (std::uint16_t units = 0; units < 20; ++units) {
    const double meters = 0.25 * units;
    EXPECT_EQ(cell.is_free(units), meters >= 1.1 && meters <= 2.9) << meters;
  }
  map.claim(3, 0, 0.5F);
  EXPECT_TRUE(cell.is_free(0));
  EXPECT_TRUE(cell.is_free(2));
  EXPECT_FALSE(cell.is_free(3));
  map.claim(3, 2, 1);
  for (std::uint16_t units = 0; units < 20; ++units) EXPECT_FALSE(cell.is_free(units));
  map.claim(3, 0, 0);
  EXPECT_FALSE(cell.is_free(0)) << "no evidence";
  // As far as numbers go; nothing is free beyond.
  map.claim(3, 0, std::numeric_limits<float>::infinity());
  EXPECT_TRUE(cell.is_free(map.distance(16000)));
  EXPECT_EQ(map.distance(1e9F), 65534);
  EXPECT_FALSE(cell.is_free(map.distance(1e9F)));
  map.clear();
  EXPECT_FALSE(cell.is_free(map.distance(1)));
}

TEST(FreeSpaceMap, ARunIsWhatItsCellsHaveInCommonAllAround) {
  sim::Rng rng(6);
  for (const double width : {10 * rad_per_deg, 2.3 * rad_per_deg, 0.25 * rad_per_deg}) {
    FreeSpaceMap map;
    map.set(0, 0, width, 0.002);
    for (std::size_t cell = 0; cell < map.size(); ++cell)
      map.claim(cell, static_cast<float>(rng.uniform()), static_cast<float>(0.9 + 10 * rng.uniform()));
    map.find_runs();
    for (int round = 0; round < 500; ++round) {
      const auto first = static_cast<std::size_t>(rng.uniform() * static_cast<double>(map.size()));
      // Long runs are hardly ever free.
      const auto length = 1 + static_cast<std::size_t>(std::pow(rng.uniform(), 3) * 512);
      FreeSpaceMap::RunAt at;
      ASSERT_TRUE(map.find_run(first, length, at));
      const FreeSpaceMap::Run a = map.runs()[at.first], b = map.runs()[at.second];
      const auto meters = static_cast<float>(12 * rng.uniform());
      const std::int16_t near = FreeSpaceMap::ordered(map.distance(meters));
      const bool run_is_free = std::max(a.from, b.from) <= near &&
                               std::max(a.not_to, b.not_to) <= static_cast<std::int16_t>(~near);
      bool all_are_free = true;
      for (std::size_t i = 0; i < length; ++i)
        all_are_free = all_are_free && map.runs()[(first + i) % map.size()].is_free(map.distance(meters));
      ASSERT_EQ(run_is_free, all_are_free) << width << ' ' << first << " + " << length << " at " << meters;
    }
    FreeSpaceMap::RunAt at;
    EXPECT_FALSE(map.find_run(0, 0, at));
    EXPECT_TRUE(map.find_run(0, 512, at));
    EXPECT_FALSE(map.find_run(0, 513, at));
  }
}

TEST(FreeSpaceMap, CellsAreFineAndDivideTheBeamsEvenly) {
  for (const double width : {1 * rad_per_deg, -1 * rad_per_deg, 0.5 * rad_per_deg, 0.25 * rad_per_deg,
                             0.1 * rad_per_deg, 5 * rad_per_deg}) {
    FreeSpaceMap map;
    map.set(0, 0, width, 0.002);
    const double cells_per_beam = static_cast<double>(map.size()) * std::abs(width) / (two_pi);
    EXPECT_NEAR(cells_per_beam, std::round(cells_per_beam), 1e-6) << width / rad_per_deg;
    EXPECT_LE(two_pi / static_cast<double>(map.size()), 0.2 * rad_per_deg * 1.001) << width / rad_per_deg;
    EXPECT_LE(cells_per_beam, std::abs(width) / (0.2 * rad_per_deg) + 1) << "and not finer than needed";
  }
  FreeSpaceMap map;
  EXPECT_EQ(map.size(), 0U);
  map.set(0, 0, 1e-9, 0.002);
  EXPECT_LE(map.size(), 65535U) << "a cell's number has 16 bits";
}

}  // namespace
}  // namespace lidard
