// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// What a beam without return proves, and which ring is the lowest on the vehicle.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/virtual/ring_grid.h"
#include "test/core/virtual/small_lidar.h"

namespace lidard {
namespace {

using namespace test::rings;

TEST(RingGrid, BeamsWithoutReturnBesideAGapPointWhereTheyWereFired) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    SmallLidar lidar(seed);
    lidar.scatter_offsets(20);
    lidar.miss_some();
    for (std::size_t c = 100; c < 112; ++c) lidar.lost.insert(c);
    for (std::size_t c = 200; c < 290; ++c) lidar.lost.insert(c);
    RingGridSettings settings;
    settings.no_return_free_range = 40;
    RingGrid grid(settings);
    ASSERT_TRUE(grid.organise(lidar.cloud()));
    std::size_t beside = 0;
    for (std::size_t i = 0; i < grid.kind.size(); ++i) {
      if (grid.kind[i] != Beam::none) continue;
      const std::size_t ring = i % grid.rings();
      beside += grid.has_column(i / grid.rings()) ? 0U : 1U;
      double nearest = 10;
      for (const auto& [column, missed] : lidar.missing) {
        if (missed == ring && lidar.lost.count(column) == 0)
          nearest = std::min(nearest, std::abs(turn_between(azimuth_of(grid.ends[i]),
                                                            lidar.azimuth(column) + lidar.offsets[ring])));
      }
      EXPECT_LE(nearest, 0.7 * grid.step()) << seed << ' ' << i / grid.rings() << ' ' << ring;
    }
    EXPECT_GT(beside, 0U);
  }
}

TEST(RingGrid, ALidarThatLeavesOutFarReturnsProvesNothingBeyond) {
  SmallLidar lidar(2);
  lidar.miss_some();
  Cloud cloud = lidar.cloud();
  cloud.max_range = 5;
  RingGridSettings settings;
  settings.no_return_free_range = 40;
  RingGrid grid(settings);
  ASSERT_TRUE(grid.organise(cloud));
  EXPECT_GT(std::count(grid.kind.begin(), grid.kind.end(), Beam::none), 10);
  for (std::size_t i = 0; i < grid.kind.size(); ++i) {
    if (grid.kind[i] != Beam::none) continue;
    EXPECT_EQ(grid.range[i], 5);
  }
}

TEST(RingGrid, UpsideDownTheLastRingIsTheLowest) {
  for (const bool in_columns : {true, false}) {
    SmallLidar lidar(1);
    lidar.scatter_offsets(5);
    Cloud cloud = lidar.cloud();
    if (!in_columns) cloud.columns.clear();
    RingGrid grid({});
    grid.set_footprint({}, make_pose({0, 0, 1}, {pi_d, 0, 0}));
    ASSERT_TRUE(grid.organise(cloud));
    for (std::size_t row = 0; row < grid.rings(); ++row)
      EXPECT_NEAR(grid.elevation(row), lidar.elevations[grid.rings() - 1 - row], 1e-3);
    for (std::size_t i = 0; i < grid.kind.size(); ++i) {
      if (grid.kind[i] != Beam::point) continue;
      EXPECT_NEAR(elevation_of(grid.ends[i]), grid.elevation(i % grid.rings()), 1e-3);
    }
  }
}

}  // namespace
}  // namespace lidard
