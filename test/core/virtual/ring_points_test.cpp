// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Clouds without columns, some of them without rings; and what is learnt of rings.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "core/virtual/ring_grid.h"
#include "test/core/virtual/small_lidar.h"

namespace lidard {
namespace {

using namespace test::rings;

Cloud without_columns(Cloud cloud, std::uint64_t seed) {
  cloud.columns.clear();
  sim::Rng rng(seed);
  for (std::size_t i = cloud.size() - 1; i > 0; --i)
    std::swap(cloud.points()[i],
              cloud.points()[static_cast<std::size_t>(rng.uniform() * static_cast<double>(i + 1))]);
  return cloud;
}

std::size_t points_in(const RingGrid& grid) {
  return static_cast<std::size_t>(std::count(grid.kind.begin(), grid.kind.end(), Beam::point));
}

TEST(RingPoints, ReturnsInAnyOrderFindAColumnThoughEveryRingHasItsOwnPhase) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SmallLidar lidar(seed);
    lidar.scatter_offsets(0.5);
    lidar.jitter = 0.1;
    const Cloud cloud = without_columns(lidar.cloud(), seed);
    RingGrid grid({});
    ASSERT_TRUE(grid.organise(cloud)) << grid.why_not();
    EXPECT_FALSE(grid.fired_in_columns());
    EXPECT_EQ(grid.columns(), 360U);
    EXPECT_NEAR(grid.step(), lidar.step(), 1e-6);
    EXPECT_EQ(points_in(grid), cloud.size()) << seed << ": each has a place of its own";
    EXPECT_EQ(grid.outside, 0U);
    for (std::size_t i = 0; i < grid.kind.size(); ++i) {
      ASSERT_NEAR(elevation_of(grid.ends[i]), lidar.elevations[i % grid.rings()], 1e-4);
      const std::size_t next = grid.index(grid.after(i / grid.rings()), i % grid.rings());
      const double step = turn_between(azimuth_of(grid.ends[next]), azimuth_of(grid.ends[i])) / grid.step();
      ASSERT_NEAR(step, 1, 0.45) << seed;
    }
  }
}

TEST(RingPoints, RingNumbersMayCountFromAnywhereAndTheRowsAscend) {
  SmallLidar lidar(3);
  Cloud cloud = without_columns(lidar.cloud(), 3);
  const std::uint16_t number[] = {3, 0, 4, 1, 2};
  for (std::size_t i = 0; i < cloud.size(); ++i) cloud.points()[i].ring = number[cloud.points()[i].ring];
  RingGrid grid({});
  ASSERT_TRUE(grid.organise(cloud));
  for (std::size_t r = 0; r < grid.rings(); ++r) {
    EXPECT_NEAR(grid.elevation(r), lidar.elevations[r], 1e-4);
    EXPECT_NEAR(elevation_of(grid.ends[grid.index(7, r)]), lidar.elevations[r], 1e-4);
  }
}

TEST(RingPoints, ARingWithoutReturnsIsNotKnownAndStandsLast) {
  SmallLidar lidar(4);
  Cloud cloud = without_columns(lidar.cloud(), 4);
  for (std::size_t i = 0; i < cloud.size(); ++i)
    cloud.points()[i].ring = static_cast<std::uint16_t>(cloud.points()[i].ring + 1);
  cloud.rings = 6;
  RingGridSettings settings;
  settings.no_return_free_range = 40;
  RingGrid grid(settings);
  ASSERT_TRUE(grid.organise(cloud));
  for (std::size_t r = 0; r < 5; ++r) {
    EXPECT_TRUE(grid.is_known(r));
    EXPECT_NEAR(grid.elevation(r), lidar.elevations[r], 1e-4);
  }
  EXPECT_FALSE(grid.is_known(5));
  for (std::size_t c = 0; c < grid.columns(); ++c) ASSERT_EQ(grid.kind[grid.index(c, 5)], Beam::unknown);
}

TEST(RingPoints, APointWhoseRingThereIsNotIsCountedAndLeftOut) {
  SmallLidar lidar(5);
  Cloud cloud = without_columns(lidar.cloud(), 5);
  for (std::size_t i = 0; i < 30; ++i) cloud.points()[i].ring = 77;
  RingGrid grid({});
  ASSERT_TRUE(grid.organise(cloud));
  EXPECT_EQ(grid.outside, 30U);
  EXPECT_GE(points_in(grid), cloud.size() - 30) << "gaps of single beams are bridged";
}

TEST(RingPoints, MissingBeamsOfAColumnWithOthersDidNotComeBack) {
  SmallLidar lidar(6);
  lidar.range = [](std::size_t ring, std::size_t column) {
    return (ring == 2 && column > 100 && column < 120) || (column > 200 && column < 220) ? 0.0 : 8.0;
  };
  RingGridSettings settings;
  settings.no_return_free_range = 40;
  RingGrid grid(settings);
  ASSERT_TRUE(grid.organise(without_columns(lidar.cloud(), 6)));
  EXPECT_EQ(std::count(grid.kind.begin(), grid.kind.end(), Beam::none), 19);
  EXPECT_EQ(std::count(grid.kind.begin(), grid.kind.end(), Beam::unknown), 19 * 5)
      << "nobody knows if they were fired";
}

TEST(RingPoints, OfTwoReturnsInOnePlaceTheNearerHides) {
  SmallLidar far(7), near(7);
  far.range = [](std::size_t, std::size_t) { return 9.0; };
  near.range = [](std::size_t ring, std::size_t column) { return ring == 1 && column == 60 ? 3.0 : 0.0; };
  for (const bool near_first : {true, false}) {
    Cloud cloud =
        near_first ? both_echoes(near.cloud(), far.cloud()) : both_echoes(far.cloud(), near.cloud());
    cloud.columns.clear();
    RingGrid grid({});
    ASSERT_TRUE(grid.organise(cloud));
    std::size_t nearer = 0;
    for (std::size_t i = 0; i < grid.kind.size(); ++i) nearer += grid.range[i] < 4 ? 1 : 0;
    EXPECT_EQ(nearer, 1U) << near_first;
  }
}

TEST(RingPoints, TheCoarsestRingTellsTheColumns) {
  // The upper rings are measured twice as finely.
  SmallLidar coarse(8), fine(8);
  coarse.range = [](std::size_t ring, std::size_t) { return ring < 3 ? 8.0 : 0.0; };
  fine.columns = 720;
  fine.range = [](std::size_t ring, std::size_t) { return ring < 3 ? 0.0 : 8.0; };
  Cloud cloud = coarse.cloud();
  const Cloud upper = fine.cloud();
  cloud.points_bytes.insert(cloud.points_bytes.end(), upper.points_bytes.begin(), upper.points_bytes.end());
  RingGrid grid({});
  ASSERT_TRUE(grid.organise(without_columns(cloud, 8)));
  EXPECT_EQ(grid.columns(), 360U);
  EXPECT_EQ(points_in(grid), grid.kind.size());
}

TEST(RingPoints, ARingWithFewReturnsTellsNoStep) {
  SmallLidar lidar(8);
  lidar.columns = 720;
  lidar.range = [](std::size_t ring, std::size_t column) {
    return ring == 4 && (column % 3 != 0 || column > 60) ? 0.0 : 8.0;
  };
  RingGrid grid({});
  ASSERT_TRUE(grid.organise(without_columns(lidar.cloud(), 8)));
  EXPECT_EQ(grid.columns(), 720U);
}

TEST(RingPoints, ARingThatHitsLeavesTellsNoStep) {
  RingGrid grid({});
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SmallLidar lidar(seed);
    lidar.columns = 720;
    for (std::size_t column = 0; column < lidar.columns; ++column)
      if (lidar.rng.uniform() > 0.3) lidar.missing.insert({column, 4});
    ASSERT_TRUE(grid.organise(without_columns(lidar.cloud(), seed)));
    ASSERT_EQ(grid.columns(), 720U) << seed;
  }
}

TEST(RingPoints, FollowsADeviceThatIsSetToOtherSteps) {
  RingGridSettings settings;
  settings.no_return_free_range = 40;
  RingGrid grid(settings);
  for (const std::size_t columns : {720U, 360U, 720U}) {
    SmallLidar lidar(9);
    lidar.columns = columns;
    lidar.scatter_offsets(0.5);
    const Cloud cloud = without_columns(lidar.cloud(), 9);
    for (int i = 0; i < 60; ++i) ASSERT_TRUE(grid.organise(cloud));
    EXPECT_EQ(grid.columns(), columns);
    EXPECT_EQ(points_in(grid), cloud.size()) << "no beam is without return";
  }
}

TEST(RingPoints, SaysWhyACloudIsNoGrid) {
  const auto why_not = [](const Cloud& cloud) {
    RingGrid grid({});
    return grid.organise(cloud) ? std::string("organised") : std::string(grid.why_not());
  };
  SmallLidar lidar(9);
  EXPECT_EQ(why_not(without_columns(lidar.cloud(), 9)), "organised");
  Cloud blob = without_columns(lidar.cloud(), 9);
  blob.rings = 1;
  for (std::size_t i = 0; i < blob.size(); ++i) {
    blob.points()[i].ring = 0;
    blob.points()[i].z = static_cast<float>(lidar.rng.uniform() * 4);
  }
  EXPECT_EQ(why_not(blob), "its returns do not fall into rings");
  SmallLidar few(9);
  few.range = [](std::size_t, std::size_t column) { return column < 6 ? 8.0 : 0.0; };
  EXPECT_EQ(why_not(without_columns(few.cloud(), 9)),
            "its rings have too few returns to measure their azimuth step");
  Cloud empty;
  empty.rings = 16;
  EXPECT_EQ(why_not(empty), "its rings have too few returns to measure their azimuth step");
}

TEST(RingPoints, RingsThatAreNotNumberedAreFoundByTheirElevations) {
  SmallLidar lidar(10);
  Cloud cloud = without_columns(lidar.cloud(), 10);
  for (std::size_t i = 0; i < cloud.size(); ++i) cloud.points()[i].ring = 0;
  cloud.rings = 1;
  RingGrid grid({});
  ASSERT_TRUE(grid.organise(cloud)) << grid.why_not();
  ASSERT_EQ(grid.rings(), 5U);
  EXPECT_EQ(points_in(grid), cloud.size());
  for (std::size_t i = 0; i < grid.kind.size(); ++i)
    ASSERT_NEAR(elevation_of(grid.ends[i]), lidar.elevations[i % 5], 1e-4);
}

TEST(FindRings, SingleStrayReturnsAreNoRingAndNearOnesTellNothing) {
  SmallLidar lidar(11);
  Cloud cloud = lidar.cloud();
  cloud.points()[3].z = 2;  // a stray return
  std::vector<float> found;
  find_rings(cloud, found);
  ASSERT_EQ(found.size(), 5U);
  for (std::size_t r = 0; r < 5; ++r) EXPECT_NEAR(found[r], lidar.elevations[r], 0.0006) << r;
  // Returns nearer than 2 m come from beams that start beside the middle.
  lidar.range = [](std::size_t ring, std::size_t) { return ring == 2 ? 1.9 : 6.0; };
  find_rings(lidar.cloud(), found);
  EXPECT_EQ(found.size(), 4U);
  lidar.range = [](std::size_t ring, std::size_t) { return ring == 2 ? 6.0 : 1.9; };
  find_rings(lidar.cloud(), found);
  EXPECT_TRUE(found.empty()) << "one ring is none";
}

TEST(FindRings, ATenthOfTheReturnsMayLieBetweenTheRingsAndNoMore) {
  for (const double share : {0.08, 0.13}) {
    SmallLidar lidar(12);
    lidar.columns = 3600;
    Cloud cloud = lidar.cloud();
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      CloudPoint& p = cloud.points()[i];
      if (lidar.rng.uniform() >= share) continue;
      p.z = std::hypot(p.x, p.y) * static_cast<float>(std::tan(0.3 + 1.1 * lidar.rng.uniform()));
    }
    std::vector<float> found;
    find_rings(cloud, found);
    EXPECT_EQ(found.size(), share < 0.1 ? 5U : 0U) << share;
  }
}

TEST(RingTable, LearnsElevationsAndOffsetsAndFollowsAChange) {
  SmallLidar lidar(13);
  lidar.scatter_offsets(5);
  RingTable table;
  Cloud of_five, of_six;
  of_five.rings = 5;
  of_six.rings = 6;
  of_six.directions.assign(6, {0.2, 0.1});
  table.set_rings(of_five);
  EXPECT_FALSE(table.is_known(0));
  EXPECT_EQ(table.elevation(0), 0);
  table.learn(lidar.cloud(), true);
  for (std::size_t r = 0; r < 5; ++r) {
    EXPECT_TRUE(table.is_known(r));
    EXPECT_NEAR(table.elevation(r), lidar.elevations[r], 1e-5);
    EXPECT_NEAR(table.offset(r), lidar.offsets[r], 1e-5);
  }
  const double before = lidar.offsets[1];
  lidar.offsets[1] += 0.02;
  for (int cloud = 0; cloud < 10; ++cloud) table.learn(lidar.cloud(), true);
  EXPECT_LT(table.offset(1), before + 0.01) << "a few clouds change little";
  for (int cloud = 0; cloud < 2500; ++cloud) table.learn(lidar.cloud(), true);
  EXPECT_NEAR(table.offset(1), lidar.offsets[1], 0.005);
  table.set_rings(of_five);
  EXPECT_TRUE(table.is_known(0)) << "nothing changed";
  table.set_rings(of_six);
  EXPECT_TRUE(table.is_known(0)) << "from the model's table, without a return";
  EXPECT_EQ(table.elevation(5), 0.2);
  EXPECT_EQ(table.offset(5), 0.1);
}

}  // namespace
}  // namespace lidard
