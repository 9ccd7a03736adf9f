// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/virtual/ring_links.h"

#include <gtest/gtest.h>

#include <cmath>

#include "test/core/virtual/small_lidar.h"
#include "test/sim/world/units.h"

namespace lidard {
namespace {

using namespace test::rings;

/// Degrees between the line through two returns of beams `apart` and the beam of the nearer one.
double steepness(double a, double b, double apart) {
  const double near = std::min(a, b), far = std::max(a, b);
  return std::atan2(far * std::sin(apart), far * std::cos(apart) - near) / degree;
}

/// Returns at random ranges, each pair of neighbours with nothing else around it.
struct Pairs {
  explicit Pairs(std::uint64_t seed, std::vector<double> elevations) : lidar(seed) {
    lidar.elevations = std::move(elevations);
    lidar.offsets.assign(lidar.elevations.size(), 0);
  }
  void organise() {
    cloud = lidar.cloud();
    EXPECT_TRUE(grid.organise(cloud));
    links.set(grid, 0);
  }
  double range(std::size_t column, std::size_t ring) const {
    return static_cast<double>(grid.range[grid.index(column, ring)]);
  }
  SmallLidar lidar;
  Cloud cloud;
  RingGrid grid{RingGridSettings{}};
  RingLinks links;
};

TEST(RingLinks, NeighboursInARingAreOneSurfaceUnlessSteeperThanNineDegreesAgainstTheBeam) {
  int one = 0, two = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Pairs pairs(seed, {-0.02, 0, 0.02});
    // Two columns with returns, then four without.
    pairs.lidar.range = [&](std::size_t, std::size_t column) {
      return column % 6 < 2 || column > 355 ? 5 + (column % 6 == 1 ? 1.2 * pairs.lidar.rng.uniform() : 0.0)
                                            : 0.0;
    };
    pairs.organise();
    for (std::size_t c = 0; c < 354; c += 6) {
      for (std::size_t r = 0; r < 3; ++r) {
        const double apart = pairs.grid.step() * std::cos(pairs.lidar.elevations[r]);
        const double steep = steepness(pairs.range(c, r), pairs.range(c + 1, r), apart);
        if (std::abs(steep - 9) < 0.1) continue;
        ASSERT_EQ(pairs.links.level(c, r), steep > 9) << seed << ' ' << c << ' ' << steep;
        ASSERT_FALSE(pairs.links.level(c + 1, r)) << "nothing is there";
        ++(steep > 9 ? one : two);
      }
    }
  }
  EXPECT_GT(one, 300);
  EXPECT_GT(two, 300);
}

TEST(RingLinks, NeighboursInAColumnMayBeLessSteepWhereRingsAreWideApart) {
  // 1, 2 and 6 degrees between rings: no steeper than 9, 9 and three times 6 degrees.
  int one[3] = {}, two[3] = {};
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Pairs pairs(seed, {0, 1 * degree, 7 * degree, 9 * degree});
    const std::size_t lower[] = {0, 2, 1};
    const double apart[] = {1, 2, 6}, least[] = {9, 9, 18};
    for (int which = 0; which < 3; ++which) {
      pairs.lidar.range = [&](std::size_t ring, std::size_t) {
        if (ring == lower[which]) return 6.0;
        return ring == lower[which] + 1 ? 6 + 5 * (pairs.lidar.rng.uniform() - 0.5) : 0.0;
      };
      // Each ring must have been seen once for its elevation to be known.
      pairs.lidar.missing.clear();
      const auto only_two = pairs.lidar.range;
      pairs.lidar.range = [&](std::size_t ring, std::size_t column) {
        return column < 10 ? 6.0 : only_two(ring, column);
      };
      pairs.organise();
      for (std::size_t c = 10; c < 360; ++c) {
        const double steep =
            steepness(pairs.range(c, lower[which]), pairs.range(c, lower[which] + 1), apart[which] * degree);
        if (std::abs(steep - least[which]) < 0.3) continue;
        ASSERT_EQ(pairs.links.upright(c, lower[which]), steep > least[which]) << which << ' ' << steep;
        ++(steep > least[which] ? one : two)[which];
      }
    }
  }
  for (int which = 0; which < 3; ++which) {
    EXPECT_GT(one[which], 50) << which;
    EXPECT_GT(two[which], 50) << which;
  }
}

/// A wall in the plane x = `ahead`, seen by all beams that reach it within 200 m.
void see_wall(SmallLidar& lidar, double ahead) {
  lidar.first_azimuth = 0;
  lidar.range = [&lidar, ahead](std::size_t ring, std::size_t column) {
    const double along = std::cos(lidar.azimuth(column)) * std::cos(lidar.elevations[ring]);
    return along > ahead / 200 ? ahead / along : 0.0;
  };
}

TEST(RingLinks, AGrazingWallIsOneSurfaceAcrossTheSeamToo) {
  Pairs pairs(1, {-0.05, 0, 0.05});
  see_wall(pairs.lidar, 1);
  pairs.lidar.first_azimuth = -84 * degree;  // the seam lies where the wall is grazed at 6 degrees
  pairs.organise();
  for (const std::size_t column : {358U, 359U, 0U, 1U, 166U, 167U})
    EXPECT_TRUE(pairs.links.level(column, 1)) << column;
  // Off the line of the four.
  const auto wall = pairs.lidar.range;
  pairs.lidar.range = [&](std::size_t ring, std::size_t column) {
    return wall(ring, column) * (column == 1 ? 1.3 : 1);
  };
  pairs.organise();
  EXPECT_FALSE(pairs.links.level(359, 1));
}

TEST(RingLinks, InLineMeansWithinTheNoise) {
  Pairs pairs(2, {-0.05, 0, 0.05});
  pairs.lidar.range = [](std::size_t ring, std::size_t) { return ring == 1 ? 5.02 : 5.0; };
  pairs.organise();
  // On a sphere of 5 m three beams 0.05 rad apart bend by 6 mm; the middle one stands out by 2 cm more.
  const std::size_t i = pairs.grid.index(7, 0);
  pairs.links.set(pairs.grid, 0.01);
  EXPECT_TRUE(pairs.links.in_line(i, i + 1, i + 2));
  pairs.links.set(pairs.grid, 0.003);
  EXPECT_FALSE(pairs.links.in_line(i, i + 1, i + 2));
  EXPECT_NEAR(pairs.links.slack(), 0.009, 1e-6);
}

TEST(Ground, APlaneIsWhatLiesNoHigherThanToldWhateverTheMount) {
  sim::Rng rng(5);
  std::size_t ground_returns = 0, others = 0;
  for (int round = 0; round < 10; ++round) {
    SmallLidar lidar(static_cast<std::uint64_t>(round) + 1);
    lidar.range = [&](std::size_t, std::size_t) { return rng.uniform() < 0.1 ? 0.0 : 2 + 8 * rng.uniform(); };
    RingGrid grid({});
    ASSERT_TRUE(grid.organise(lidar.cloud()));
    const Pose mount = make_pose({1, -2, 1.2}, {0.2 * rng.uniform(), 0.2 * rng.uniform(), 6 * rng.uniform()});
    GroundSettings settings;
    settings.model = GroundModel::plane;
    settings.z = 0.3;
    settings.tolerance = 0.15;
    Ground ground;
    find_ground(grid, settings, mount, ground);
    EXPECT_TRUE(ground.known);
    EXPECT_NEAR(ground.sensor, 0.9, 1e-6);
    for (std::size_t i = 0; i < grid.kind.size(); ++i) {
      if (grid.kind[i] != Beam::point) {
        ASSERT_EQ(ground.is_ground[i], 0);
        continue;
      }
      const BeamEnd& end = grid.ends[i];
      const Eigen::Vector3d ray = mount.linear() * Eigen::Vector3f(end.x, end.y, end.z).cast<double>();
      const double height = ray.z() + 1.2 - 0.3;
      ASSERT_NEAR(ground.height[i], height, 1e-4);
      ASSERT_NEAR(ground.distance[i], ray.head<2>().norm(), 1e-3);
      if (std::abs(height - 0.15) < 1e-3) continue;
      ASSERT_EQ(ground.is_ground[i] != 0, height < 0.15);
      ++(height < 0.15 ? ground_returns : others);
    }
  }
  EXPECT_GT(ground_returns, 1000U);
  EXPECT_GT(others, 1000U);
}

/// What a lidar 2 m above the ground sees of ground whose height depends on the distance.
struct Terrain {
  std::vector<char> is_ground;  // by ring, from below
  std::vector<double> distance;
  template <class Height>
  Terrain(const GroundSettings& settings, Height height) {
    SmallLidar lidar(1);
    lidar.elevations.clear();
    for (double e = -50; e < 6; e += 2) lidar.elevations.push_back(e * degree);
    lidar.offsets.assign(lidar.elevations.size(), 0);
    lidar.range = [&](std::size_t ring, std::size_t) {
      const double e = lidar.elevations[ring];
      for (double r = 0.5; r < 80; r += 0.002) {
        if (2 + r * std::sin(e) <= height(r * std::cos(e))) return r;
      }
      return 0.0;
    };
    std::vector<double> of_ring;
    for (std::size_t r = 0; r < lidar.elevations.size(); ++r) of_ring.push_back(lidar.range(r, 0));
    lidar.range = [&](std::size_t ring, std::size_t) { return of_ring[ring]; };
    RingGrid grid({});
    EXPECT_TRUE(grid.organise(lidar.cloud()));
    Ground ground;
    find_ground(grid, settings, make_pose({0, 0, 2}, {0, 0, 0}), ground);
    for (std::size_t r = 0; r < grid.rings(); ++r) {
      is_ground.push_back(ground.is_ground[grid.index(11, r)]);
      distance.push_back(of_ring[r] * std::cos(lidar.elevations[r]));
    }
  }
  /// Ground returns of all between two distances.
  std::pair<int, int> between(double from, double to) const {
    int ground = 0, all = 0;
    for (std::size_t r = 0; r < distance.size(); ++r) {
      if (distance[r] <= 0 || distance[r] < from || distance[r] > to) continue;
      ++all;
      ground += is_ground[r] != 0 ? 1 : 0;
    }
    return {ground, all};
  }
};

GroundSettings sloping() {
  GroundSettings settings;
  settings.model = GroundModel::slope;
  return settings;
}

TEST(Ground, ASlopeIsGroundAsFarAsItIsNotTooSteep) {
  for (const double rise : {0.0, 0.1, -0.1}) {
    const auto [ground, all] = Terrain(sloping(), [&](double d) { return rise * d; }).between(0, 12);
    EXPECT_EQ(ground, all) << rise;
    EXPECT_GT(all, 15);
  }
  // Steeper from 4 m on: a third of a metre a metre is no ground once it has risen by more than noise.
  const Terrain steep(sloping(), [](double d) { return d < 4 ? 0 : 0.35 * (d - 4); });
  EXPECT_EQ(steep.between(0, 4).first, steep.between(0, 4).second);
  EXPECT_EQ(steep.between(5.5, 80).first, 0);
}

TEST(Ground, AWallIsNotClimbedAndTheGroundGoesOnBehindALowStep) {
  const Terrain wall(sloping(), [](double d) { return d < 5 ? 0.0 : 9.0; });
  const auto [foot, all] = wall.between(4.99, 5.1);
  EXPECT_GE(all, 8);
  EXPECT_LE(foot, 1) << "only its very foot may pass";
  const Terrain kerb(sloping(), [](double d) { return d < 5 ? 0.0 : 0.09; });
  EXPECT_EQ(kerb.between(0, 15).first, kerb.between(0, 15).second);
  const Terrain block(sloping(), [](double d) { return d > 5 && d < 6 ? 0.7 : 0.0; });
  EXPECT_EQ(block.between(5, 6).first, 0);
  EXPECT_EQ(block.between(0, 4.9).first, block.between(0, 4.9).second);
  EXPECT_GT(block.between(6.1, 20).first, 0);
  EXPECT_EQ(block.between(6.1, 20).first, block.between(6.1, 20).second);
}

TEST(Ground, BetweenSparseRingsNoMoreThanThreeTenthsOfAMetreAreASlope) {
  // Beyond 19 m the rings are 5 m apart and more; 0.15 a metre would allow 0.7 m.
  const auto far_ring = [](double rise) {
    const Terrain terrain(sloping(), [&](double d) { return d < 20 ? 0.0 : rise; });
    return terrain.between(20, 60);
  };
  EXPECT_EQ(far_ring(0.35).first, far_ring(0.35).second);
  EXPECT_GT(far_ring(0.35).second, 0);
  EXPECT_EQ(far_ring(0.5).first, 0);
}

TEST(Ground, WithoutAModelNothingIsGround) {
  SmallLidar lidar(1);
  RingGrid grid({});
  ASSERT_TRUE(grid.organise(lidar.cloud()));
  Ground ground;
  find_ground(grid, {}, make_pose({0, 0, -50}, {0, 0, 0}), ground);
  EXPECT_FALSE(ground.known);
  EXPECT_EQ(std::count(ground.is_ground.begin(), ground.is_ground.end(), 0),
            static_cast<long>(grid.kind.size()));
}

}  // namespace
}  // namespace lidard
