// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/virtual/ring_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "test/core/virtual/small_lidar.h"

namespace lidard {
namespace {

using namespace test::rings;

std::size_t count(const RingGrid& grid, Beam kind) {
  return static_cast<std::size_t>(std::count(grid.kind.begin(), grid.kind.end(), kind));
}

/// The cell that holds a return; the number of cells if none does.
std::size_t cell_of(const RingGrid& grid, const CloudPoint& p) {
  for (std::size_t i = 0; i < grid.kind.size(); ++i) {
    const BeamEnd& end = grid.ends[i];
    if (grid.kind[i] == Beam::point && end.x == p.x && end.y == p.y && end.z == p.z) return i;
  }
  return grid.kind.size();
}

/// All beams of a column point the same way within half a column, and those of the next one a step farther.
void expect_straight(const RingGrid& grid, double slack = 0.55) {
  for (std::size_t c = 0; c < grid.columns(); ++c) {
    std::size_t first = grid.kind.size();
    for (std::size_t r = 0; r < grid.rings(); ++r) {
      const std::size_t i = grid.index(c, r);
      if (grid.kind[i] != Beam::point) continue;
      EXPECT_NEAR(elevation_of(grid.ends[i]), grid.elevation(r), 1e-3);
      if (first == grid.kind.size()) first = i;
      ASSERT_LE(std::abs(turn_between(azimuth_of(grid.ends[i]), azimuth_of(grid.ends[first]))),
                2 * slack * grid.step())
          << c << ' ' << r;
      const std::size_t next = grid.index(grid.after(c), r);
      if (grid.kind[next] != Beam::point) continue;
      ASSERT_NEAR(turn_between(azimuth_of(grid.ends[next]), azimuth_of(grid.ends[i])), grid.step(),
                  0.5 * grid.step())
          << c << ' ' << r;
    }
  }
}

TEST(RingGrid, EveryReturnHasItsPlaceWhereverTheTurnBeginsAndTheLasersPoint) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    SmallLidar lidar(seed);
    if (seed % 3 != 0) lidar.scatter_offsets(6);
    if (seed % 2 == 0) lidar.miss_some();
    const Cloud cloud = lidar.cloud();
    RingGrid grid({});
    ASSERT_TRUE(grid.organise(cloud));
    EXPECT_TRUE(grid.fired_in_columns());
    EXPECT_EQ(grid.columns(), lidar.columns);
    EXPECT_EQ(grid.rings(), lidar.elevations.size());
    EXPECT_NEAR(grid.step(), 2 * pi_d / static_cast<double>(lidar.columns), 1e-6);
    EXPECT_EQ(count(grid, Beam::point), cloud.size()) << seed;
    expect_straight(grid);
    for (std::size_t i = 0; i < cloud.size(); i += 37) {
      const std::size_t at = cell_of(grid, cloud.points()[i]);
      ASSERT_LT(at, grid.kind.size()) << seed;
      EXPECT_EQ(grid.ends[at].intensity, cloud.points()[i].intensity);
      EXPECT_NEAR(grid.range[at], norm(grid.ends[at]), 1e-5);
      EXPECT_EQ(at % grid.rings(), cloud.points()[i].ring);
    }
    EXPECT_EQ(grid.outside, 0U);
    EXPECT_EQ(grid.own_returns, 0U);
  }
}

TEST(RingGrid, BeamsWithoutReturnEndWhereTheyWouldHaveAndProveNothingIfNotAskedTo) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    SmallLidar lidar(seed);
    if (seed % 2 == 0) lidar.scatter_offsets(5);
    lidar.miss_some();
    const Cloud cloud = lidar.cloud();
    RingGridSettings settings;
    settings.no_return_free_range = 40;
    RingGrid grid(settings);
    ASSERT_TRUE(grid.organise(cloud));
    const std::size_t cells = lidar.columns * lidar.elevations.size();
    EXPECT_EQ(count(grid, Beam::none), cells - cloud.size()) << seed;
    for (std::size_t c = 0; c < grid.columns(); ++c) {
      for (std::size_t r = 0; r < grid.rings(); ++r) {
        const std::size_t i = grid.index(c, r);
        if (grid.kind[i] != Beam::none) continue;
        EXPECT_EQ(grid.range[i], 40);
        EXPECT_NEAR(norm(grid.ends[i]), 40, 1e-3);
        EXPECT_NEAR(elevation_of(grid.ends[i]), lidar.elevations[r], 1e-4);
        for (const std::size_t other : {std::size_t{0}, grid.rings() - 1}) {
          const std::size_t j = grid.index(c, other);
          if (grid.kind[j] != Beam::point) continue;
          ASSERT_LE(std::abs(turn_between(azimuth_of(grid.ends[i]), azimuth_of(grid.ends[j]))),
                    0.55 * grid.step());
        }
      }
    }
    RingGrid silent({});
    ASSERT_TRUE(silent.organise(cloud));
    EXPECT_EQ(count(silent, Beam::none), 0U);
    EXPECT_EQ(count(silent, Beam::unknown), cells - cloud.size());
  }
}

TEST(RingGrid, LostColumnsStayInTheirPlaceAndAreUnknown) {
  SmallLidar lidar(3);
  for (std::size_t c = 100; c < 124; ++c) lidar.lost.insert(c);
  for (std::size_t c = 200; c < 202; ++c) lidar.lost.insert(c);
  lidar.lost.insert(250);
  RingGrid grid({});
  ASSERT_TRUE(grid.organise(lidar.cloud()));
  ASSERT_EQ(grid.columns(), lidar.columns);
  for (std::size_t c = 0; c < lidar.columns; ++c) {
    EXPECT_EQ(grid.has_column(c), lidar.lost.count(c) == 0) << c;
    const bool known = lidar.lost.count(c) == 0 || c == 250;
    for (std::size_t r = 0; r < grid.rings(); ++r)
      ASSERT_EQ(grid.kind[grid.index(c, r)], known ? Beam::point : Beam::unknown) << c;
  }
  expect_straight(grid);
}

TEST(RingGrid, ASingleLostBeamIsBridgedBetweenTwoOfOneSurfaceOnly) {
  SmallLidar lidar(1);
  lidar.range = [](std::size_t ring, std::size_t column) {
    if (ring == 1 && column > 50) return 20.0;                // a step in range across the gap
    if (ring == 2 && column > 40 && column < 60) return 0.0;  // nothing on either side
    if (ring == 3 && column > 50) return 0.0;                 // a surface on one side
    if (ring == 4) return column > 50 ? 10.6 : 10.4;          // no more than a slanting surface may have
    return 10.0;
  };
  lidar.lost.insert(50);
  RingGridSettings settings;
  settings.no_return_free_range = 40;
  RingGrid grid(settings);
  ASSERT_TRUE(grid.organise(lidar.cloud()));
  const auto at = [&](std::size_t ring) { return grid.index(50, ring); };
  ASSERT_EQ(grid.kind[at(0)], Beam::point);
  EXPECT_NEAR(grid.range[at(0)], 10, 1e-3);
  EXPECT_NEAR(elevation_of(grid.ends[at(0)]), lidar.elevations[0], 1e-3);
  EXPECT_NEAR(turn_between(azimuth_of(grid.ends[at(0)]), azimuth_of(grid.ends[grid.index(49, 0)])),
              grid.step(), 1e-4);
  EXPECT_EQ(grid.kind[at(1)], Beam::unknown);
  EXPECT_EQ(grid.kind[at(2)], Beam::none);
  EXPECT_NEAR(norm(grid.ends[at(2)]), 40, 0.01);
  EXPECT_EQ(grid.kind[at(3)], Beam::unknown);
  EXPECT_EQ(grid.kind[at(4)], Beam::point);
  EXPECT_NEAR(grid.range[at(4)], 10.5, 1e-3);
}

TEST(RingGrid, TheSeamIsBridgedAsAnyOtherPlace) {
  for (const std::size_t lost : {std::size_t{0}, std::size_t{359}}) {
    SmallLidar lidar(2);
    lidar.range = [](std::size_t, std::size_t) { return 10.0; };
    lidar.lost.insert(lost);
    RingGrid grid({});
    ASSERT_TRUE(grid.organise(lidar.cloud()));
    EXPECT_EQ(count(grid, Beam::point), grid.kind.size()) << lost;
    expect_straight(grid);
  }
}

TEST(RingGrid, ReturnsOfTheVehicleAreItsOwnWhereverTheLidarStands) {
  const Footprint body({{-3, -1}, {1, -1}, {1, 1}, {-3, 1}});
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    sim::Rng rng(seed);
    SmallLidar lidar(seed);
    lidar.range = [](std::size_t ring, std::size_t column) {
      return 0.5 + static_cast<double>((ring * 31 + column * 17) % 80) / 20;
    };
    const Pose mount = make_pose({rng.uniform() - 1, rng.uniform() - 0.5, 1}, {0.1, -0.2, 6 * rng.uniform()});
    const Cloud cloud = lidar.cloud();
    std::size_t own = 0;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const CloudPoint& p = cloud.points()[i];
      const Eigen::Vector3d at = mount * Eigen::Vector3f(p.x, p.y, p.z).cast<double>();
      own += at.x() > -3 && at.x() < 1 && std::abs(at.y()) < 1 ? 1 : 0;
    }
    RingGrid grid({});
    grid.set_footprint(body, mount);
    ASSERT_TRUE(grid.organise(cloud));
    EXPECT_GT(own, 100U);
    EXPECT_EQ(grid.own_returns, own) << seed;
    EXPECT_EQ(count(grid, Beam::own), own);
    EXPECT_EQ(count(grid, Beam::point), cloud.size() - own);
  }
}

TEST(RingGrid, WhatIsTooNearToMeasureHidesWhatIsBehindButNoReturn) {
  SmallLidar lidar(4);
  lidar.scatter_offsets(5);
  lidar.missing = {{100, 2}, {359, 3}};
  lidar.lost.insert(20);
  Cloud cloud = lidar.cloud();
  const auto number_of = [](std::size_t column) {
    return static_cast<std::uint32_t>(column > 20 ? column - 1 : column);
  };
  cloud.too_near = {
      {number_of(100), 2}, {number_of(359), 3}, {number_of(50), 1}, {5000, 0}, {number_of(3), 999}};
  RingGridSettings settings;
  settings.no_return_free_range = 40;
  RingGrid grid(settings);
  ASSERT_TRUE(grid.organise(cloud));
  EXPECT_EQ(count(grid, Beam::own), 2U) << "where a return came it stays";
  for (std::size_t c = 0; c < grid.columns(); ++c) {
    for (const std::size_t ring : {2U, 3U}) {
      if (grid.kind[grid.index(c, ring)] != Beam::own) continue;
      // Its neighbours in the ring show where it looks.
      const std::size_t next = grid.index(grid.after(c), ring);
      const double expected = lidar.azimuth(ring == 2 ? 100 : 359) + lidar.offsets[ring] + grid.step();
      ASSERT_EQ(grid.kind[next], Beam::point);
      EXPECT_NEAR(turn_between(azimuth_of(grid.ends[next]), expected), 0, 0.3 * grid.step()) << ring;
    }
  }
}

TEST(RingGrid, OfSeveralReturnsOfAFiringTheFarthestIsTheSurfaceAndTheOthersAreKeptIfAskedFor) {
  for (const bool keep : {true, false}) {
    for (const bool near_first : {true, false}) {
      SmallLidar lidar(5);
      lidar.range = [](std::size_t, std::size_t) { return 9.0; };
      SmallLidar near(5);
      near.range = [](std::size_t ring, std::size_t column) {
        return ring == 2 && column % 3 == 0 ? 4.0 : 0.0;
      };
      const Cloud cloud =
          near_first ? both_echoes(near.cloud(), lidar.cloud()) : both_echoes(lidar.cloud(), near.cloud());
      RingGridSettings settings;
      settings.early_returns = keep;
      RingGrid grid(settings);
      ASSERT_TRUE(grid.organise(cloud));
      EXPECT_EQ(grid.columns(), 360U);
      EXPECT_EQ(count(grid, Beam::point), grid.kind.size());
      for (const float range : grid.range) ASSERT_NEAR(range, 9, 1e-4);
      ASSERT_EQ(grid.early.size(), keep ? 120U : 0U);
      for (const BeamEnd& p : grid.early) {
        EXPECT_NEAR(std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z), 4, 1e-4);
        EXPECT_EQ(p.intensity, 2 * 1000) << "as measured";
      }
    }
  }
}

TEST(RingGrid, WhatIsMoreThanATurnHasNoPlace) {
  SmallLidar lidar(6);
  lidar.fired = 380;
  const Cloud cloud = lidar.cloud();
  RingGrid grid({});
  ASSERT_TRUE(grid.organise(cloud));
  EXPECT_EQ(grid.columns(), 360U);
  EXPECT_EQ(grid.outside, 20U);
  expect_straight(grid);
  lidar.fired = 440;
  const Cloud far_more = lidar.cloud();
  RingGrid other({});
  other.organise(far_more);
  EXPECT_FALSE(other.fired_in_columns()) << "that is no order of firings";
}

TEST(RingGrid, APartOfATurnKeepsItsStepAndTheRestIsUnknown) {
  SmallLidar lidar(7);
  lidar.fired = 100;
  RingGrid grid({});
  ASSERT_TRUE(grid.organise(lidar.cloud()));
  EXPECT_EQ(grid.columns(), 360U);
  EXPECT_EQ(count(grid, Beam::unknown), 260 * grid.rings());
}

TEST(RingGrid, AJitteringMotorLosesNoColumn) {
  SmallLidar lidar(8);
  lidar.jitter = 0.2;
  const Cloud cloud = lidar.cloud();
  RingGrid grid({});
  ASSERT_TRUE(grid.organise(cloud));
  EXPECT_EQ(count(grid, Beam::point), cloud.size());
  EXPECT_EQ(grid.outside, 0U);
}

/// A vehicle that drives an arc while a cloud is measured.
CloudMotion arc(const Cloud& cloud, PoseTrack& track) {
  for (int i = 0; i <= 60; ++i) {
    const double t = 0.002 * i;
    track.add(cloud.stamp + span_from_seconds(t - 0.001), make_pose({8 * t, 0.5 * t, 0}, {0, 0, 1.5 * t}));
  }
  CloudMotion motion;
  EXPECT_TRUE(motion.find(cloud, make_pose({0.5, 0.2, 1}, {0, 0, 0.3}), track));
  return motion;
}

TEST(RingGrid, EndsOfBeamsMoveWithTheVehicleAndRangesStayAsMeasured) {
  for (const bool in_columns : {true, false}) {
    SmallLidar lidar(9);
    lidar.first_azimuth = 1;
    lidar.range = [](std::size_t ring, std::size_t column) {
      return column >= 200 && column < 205 ? 0.0 : 8.0 + static_cast<double>(ring);
    };
    Cloud cloud = lidar.cloud();
    PoseTrack track;
    const CloudMotion motion = arc(cloud, track);
    if (!in_columns) cloud.columns.clear();
    RingGridSettings settings;
    settings.no_return_free_range = 40;
    RingGrid grid(settings);
    ASSERT_TRUE(grid.organise(cloud, &motion));
    EXPECT_EQ(grid.fired_in_columns(), in_columns);
    std::size_t found = 0;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const CloudPoint& p = cloud.points()[i];
      const Pose move = motion.at(static_cast<double>(p.time));
      const Eigen::Vector3d now = move * Eigen::Vector3f(p.x, p.y, p.z).cast<double>();
      for (std::size_t c = 0; c < grid.columns(); ++c) {
        const BeamEnd& end = grid.ends[grid.index(c, p.ring)];
        if ((Eigen::Vector3f(end.x, end.y, end.z).cast<double>() - now).norm() > 1e-4) continue;
        EXPECT_NEAR(grid.range[grid.index(c, p.ring)], 8.0 + p.ring, 1e-4);
        ++found;
        break;
      }
    }
    EXPECT_EQ(found, cloud.size());
    if (!in_columns) continue;  // columns in which nothing came back are not known there
    std::size_t none = 0;
    for (std::size_t i = 0; i < grid.kind.size(); ++i) {
      if (grid.kind[i] != Beam::none) continue;
      const std::size_t ring = i % grid.rings(), column = i / grid.rings();
      const double a = -lidar.azimuth(column), e = lidar.elevations[ring];
      const Eigen::Vector3d ray(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e));
      const Eigen::Vector3d now = motion.at(lidar.time(column)) * (40 * ray);
      EXPECT_LT((Eigen::Vector3f(grid.ends[i].x, grid.ends[i].y, grid.ends[i].z).cast<double>() - now).norm(),
                0.02);
      ++none;
    }
    EXPECT_EQ(none, 5 * grid.rings());
  }
}

TEST(RingGrid, NumbersThatAreNotFiniteAreNoReturns) {
  SmallLidar lidar(10);
  Cloud cloud = lidar.cloud();
  for (std::size_t i = 0; i < cloud.size(); i += 50) cloud.points()[i].x = std::nanf("");
  RingGridSettings settings;
  settings.no_return_free_range = 40;
  for (const bool in_columns : {true, false}) {
    if (!in_columns) cloud.columns.clear();
    RingGrid grid(settings);
    ASSERT_TRUE(grid.organise(cloud));
    for (std::size_t i = 0; i < grid.kind.size(); ++i) {
      if (grid.kind[i] == Beam::point) {
        ASSERT_TRUE(std::isfinite(norm(grid.ends[i])));
      }
    }
    if (in_columns) {
      EXPECT_EQ(count(grid, Beam::none), (cloud.size() + 49) / 50);
    }
  }
}

}  // namespace
}  // namespace lidard
