// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/evidence/free_space_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "core/base/angle.h"
#include "test/sim/world/rng.h"
#include "test/sim/world/units.h"

namespace lidard {
namespace {

constexpr double unit = 0.002;

double turn_between(double a, double b) { return std::remainder(a - b, 2 * pi_d); }

/// A fan of beams around a source, and what they prove.
struct Fan {
  Eigen::Vector2d at{0, 0};
  double first = 0;  ///< rad
  double step = 0;   ///< rad; negative: of a scanner that is mounted upside down
  double jump = 0;   ///< rad, before the beams of the second half
  PlacedScan sweep;

  Fan(std::size_t beams, double first_rad, double step_rad) : first(first_rad), step(step_rad) {
    sweep.kind.assign(beams, Return::surface);
    sweep.linked.assign(beams, 0);
    sweep.free_from.assign(beams, 0);
    sweep.free_to.assign(beams, 0);
  }
  std::size_t beams() const { return sweep.kind.size(); }
  double angle(std::size_t beam) const {
    return first + static_cast<double>(beam) * step + (beam < beams() / 2 ? 0 : jump);
  }
  void prepare(FreeSpaceMap& map) const {
    std::vector<float> dx, dy;
    for (std::size_t i = 0; i < beams(); ++i) {
      dx.push_back(static_cast<float>(std::cos(angle(i))));
      dy.push_back(static_cast<float>(std::sin(angle(i))));
    }
    map.set(static_cast<float>(at.x()), static_cast<float>(at.y()), step, unit);
    map.place_beams(dx.data(), dy.data(), beams());
  }
  /// The free ways end where the vehicle sees them from now, `by` m farther to the left than at the sweep.
  void move(double by = 0) {
    sweep.moved = true;
    sweep.origin_x.assign(beams(), 0);
    sweep.origin_y.assign(beams(), static_cast<float>(-by));
    sweep.free_x.clear();
    sweep.free_y.clear();
    for (std::size_t i = 0; i < beams(); ++i) {
      sweep.free_x.push_back(static_cast<float>(std::cos(angle(i))) * sweep.free_to[i]);
      sweep.free_y.push_back(static_cast<float>(std::sin(angle(i))) * sweep.free_to[i] -
                             static_cast<float>(by));
    }
  }
};

double middle_of(const FreeSpaceMap& map, std::size_t cell) {
  return (static_cast<double>(cell) + 0.5) / static_cast<double>(map.size()) * 2 * pi_d - pi_d;
}

bool is_free(const FreeSpaceMap& map, std::size_t cell, double meters) {
  return map.runs()[cell].is_free(map.distance(static_cast<float>(meters)));
}

/// As far as a cell is free, m; 0: nowhere.
double free_to(const FreeSpaceMap& map, std::size_t cell) {
  const FreeSpaceMap::Run& here = map.runs()[cell];
  if (here.from > FreeSpaceMap::ordered(map.distance(std::numeric_limits<float>::max()))) return 0;
  return unit * static_cast<double>(here.to());
}

Fan random_fan(sim::Rng& rng) {
  const double width = (0.3 + 4.5 * rng.uniform()) * degree;
  const auto most = static_cast<std::size_t>(2 * pi_d / width) - 1;
  const auto beams = std::min(most, static_cast<std::size_t>(3 + 40 * rng.uniform()));
  const double sign = rng.uniform() < 0.5 ? -1 : 1;
  // The fan lies anywhere, also across the direction in which the circle of cells begins.
  Fan fan(beams, (2 * rng.uniform() - 1) * pi_d, sign * width);
  fan.at = {8 * rng.uniform() - 4, 8 * rng.uniform() - 4};
  return fan;
}

TEST(FreeSpaceMap, AWayThatPassesTheSourceIsFreeOnlyIfItsNearestPlaceIs) {
  FreeSpaceMap map;
  map.set(2, 1, degree, unit);
  for (std::size_t cell = 0; cell < map.size(); ++cell) map.claim(cell, 0.3F, 10);
  map.find_runs();
  for (double turn = 0.03; turn < 6; turn += 0.1) {
    // A way of 1 m past the source, and its parts as far as to the foot of the perpendicular.
    const auto is_free_past = [&](double beside, double begin, double end) {
      const auto place = [&](double along) {
        return map.place_of(static_cast<float>(2 + along * std::cos(turn) - beside * std::sin(turn)),
                            static_cast<float>(1 + along * std::sin(turn) + beside * std::cos(turn)));
      };
      return map.is_free(place(begin), place(end));
    };
    EXPECT_FALSE(is_free_past(0.1, -0.5, 0.5)) << turn;
    EXPECT_FALSE(is_free_past(0.28, -0.5, 0.6)) << turn;
    EXPECT_FALSE(is_free_past(0.28, -0.9, 0.4)) << turn;
    EXPECT_TRUE(is_free_past(0.6, -0.5, 0.5)) << turn;
    EXPECT_TRUE(is_free_past(0.31, 0.2, 1.2)) << turn;
  }
}

TEST(FreeSpaceMap, BetweenUnlinkedBeamsTheShorterOneCountsWhateverTheMount) {
  sim::Rng rng(1);
  std::size_t inside = 0, outside = 0;
  for (int round = 0; round < 60; ++round) {
    Fan fan = random_fan(rng);
    for (std::size_t i = 0; i < fan.beams(); ++i) {
      fan.sweep.free_from[i] = static_cast<float>(rng.uniform());
      fan.sweep.free_to[i] = rng.uniform() < 0.2 ? 0 : static_cast<float>(1.5 + 20 * rng.uniform());
    }
    FreeSpaceMap map;
    fan.prepare(map);
    fan.sweep.linked.assign(fan.beams(), 0);
    map.fill(fan.sweep);
    for (std::size_t cell = 0; cell < map.size(); ++cell) {
      // Beams from the first one on, which way round they ever go.
      double place = turn_between(middle_of(map, cell), fan.angle(0)) / fan.step;
      const double circle = 2 * pi_d / std::abs(fan.step);
      if (place < -0.5) place += circle;
      const double beam = std::round(place);
      if (std::abs(place - beam) > 0.49) continue;  // on the border between two
      if (beam >= static_cast<double>(fan.beams())) {
        ++outside;
        ASSERT_FALSE(is_free(map, cell, 1.2)) << round << " cell " << cell;
        continue;
      }
      const auto i = static_cast<std::size_t>(beam);
      double from = static_cast<double>(fan.sweep.free_from[i]);
      double to = static_cast<double>(fan.sweep.free_to[i]);
      // What the shorter of two beams meets may go on as far as to the longer one.
      const double beside = beam + (place < beam ? -1 : 1);
      const bool alone = beside < 0 || beside >= static_cast<double>(fan.beams());
      const std::size_t n = alone ? i : static_cast<std::size_t>(beside);
      const auto other = static_cast<double>(fan.sweep.free_to[n]);
      if (other > 0 && other < to) {
        from = std::max(from, static_cast<double>(fan.sweep.free_from[n]));
        to = other;
      }
      ++inside;
      ASSERT_EQ(is_free(map, cell, 1.2), to > 0) << round << " cell " << cell;
      if (to == 0) continue;
      ASSERT_TRUE(is_free(map, cell, from + 2 * unit));
      ASSERT_TRUE(is_free(map, cell, to - 2 * unit));
      ASSERT_FALSE(is_free(map, cell, to + 2 * unit));
      if (from > 2 * unit) {
        ASSERT_FALSE(is_free(map, cell, from - 2 * unit));
      }
    }
  }
  EXPECT_GT(inside, 5000U);
  EXPECT_GT(outside, 5000U);
}

/// A wall that a fan looks at from some way off, at some slant.
struct Slant {
  double distance, normal;  // m, rad
  double range(double angle) const { return distance / std::cos(angle - normal); }
};

Slant before(const Fan& fan, sim::Rng& rng) {
  const double middle = fan.angle(fan.beams() / 2);
  return {1 + 4 * rng.uniform(), middle + (2 * rng.uniform() - 1) * 0.6};
}

Fan fan_at_a_wall(const Slant*& wall, std::vector<Slant>& walls, sim::Rng& rng) {
  // Not more than 40 degrees to either side, so that the wall is met by all beams.
  Fan fan(static_cast<std::size_t>(4 + 10 * rng.uniform()), (2 * rng.uniform() - 1) * pi_d,
          (rng.uniform() < 0.5 ? -1 : 1) * (1 + 4 * rng.uniform()) * degree);
  walls.push_back(before(fan, rng));
  wall = &walls.back();
  for (std::size_t i = 0; i < fan.beams(); ++i) {
    fan.sweep.free_to[i] = static_cast<float>(wall->range(fan.angle(i)));
    fan.sweep.linked[i] = i + 1 < fan.beams() ? 1 : 0;
  }
  return fan;
}

TEST(FreeSpaceMap, BetweenTheReturnsOfAWallTheWayIsFreeAsFarAsTheWall) {
  sim::Rng rng(2);
  std::size_t compared = 0;
  for (const bool moved : {false, true}) {
    for (int round = 0; round < 200; ++round) {
      std::vector<Slant> walls;
      const Slant* wall = nullptr;
      Fan fan = fan_at_a_wall(wall, walls, rng);
      if (moved) fan.move();
      FreeSpaceMap map;
      fan.prepare(map);
      map.fill(fan.sweep);
      for (std::size_t cell = 0; cell < map.size(); ++cell) {
        const double angle = middle_of(map, cell);
        const double place = turn_between(angle, fan.angle(0)) / fan.step;
        if (place < 0.02 || place > static_cast<double>(fan.beams()) - 1.02) continue;
        const double range = wall->range(angle);
        ++compared;
        // The inverse of the range of a wall is a cosine: between beams 5 degrees apart it is even to 0.1 %.
        ASSERT_TRUE(is_free(map, cell, range * 0.9985 - 2 * unit)) << moved << ' ' << round << ' ' << place;
        ASSERT_FALSE(is_free(map, cell, range * 1.0015 + 2 * unit)) << moved << ' ' << round << ' ' << place;
      }
    }
  }
  EXPECT_GT(compared, 20000U);
}

TEST(FreeSpaceMap, WhatNoBeamLooksIntoIsNotFreeThoughTheVehicleMoved) {
  sim::Rng rng(3);
  for (int round = 0; round < 100; ++round) {
    std::vector<Slant> walls;
    const Slant* wall = nullptr;
    Fan fan = fan_at_a_wall(wall, walls, rng);
    fan.move();
    FreeSpaceMap map;
    fan.prepare(map);
    map.fill(fan.sweep);
    std::size_t free = 0;
    for (std::size_t cell = 0; cell < map.size(); ++cell) {
      const double place = turn_between(middle_of(map, cell), fan.angle(0)) / fan.step;
      const bool beside = place < -0.6 || place > static_cast<double>(fan.beams()) - 0.4;
      if (beside) {
        ASSERT_EQ(free_to(map, cell), 0) << round << ' ' << place;
      }
      free += is_free(map, cell, 0.5) ? 1 : 0;
    }
    // The outermost beams count half a beam beyond, as the others do.
    const double expected = static_cast<double>(fan.beams()) * std::abs(fan.step) / (2 * pi_d);
    EXPECT_NEAR(static_cast<double>(free) / static_cast<double>(map.size()), expected,
                expected * 0.2 + 0.003);
  }
}

TEST(FreeSpaceMap, AMovedSweepSaysTheSameAsAStandingOneWhereNothingMoved) {
  sim::Rng rng(4);
  std::size_t compared = 0;
  for (int round = 0; round < 60; ++round) {
    Fan fan = random_fan(rng);
    for (std::size_t i = 0; i < fan.beams(); ++i) {
      fan.sweep.free_from[i] = rng.uniform() < 0.5 ? 0 : static_cast<float>(rng.uniform());
      fan.sweep.free_to[i] = rng.uniform() < 0.2 ? 0 : static_cast<float>(1.5 + 10 * rng.uniform());
    }
    FreeSpaceMap standing, moved;
    fan.prepare(standing);
    fan.prepare(moved);
    standing.fill(fan.sweep);
    fan.move();
    moved.fill(fan.sweep);
    for (std::size_t cell = 0; cell < standing.size(); ++cell) {
      const double place = turn_between(middle_of(standing, cell), fan.angle(0)) / fan.step;
      const double within = std::abs(place - std::round(place));
      if (within < 0.02) continue;  // at a beam the moved sweep takes the shorter way of both sides
      const double here = free_to(standing, cell), there = free_to(moved, cell);
      ASSERT_NEAR(here, there, 2 * unit) << round << ' ' << place;
      compared += here > 0 ? 1 : 0;
    }
  }
  EXPECT_GT(compared, 2000U);
}

TEST(FreeSpaceMap, WhatOpenedWhileTheVehicleMovedIsFreeOnlyAsFarAsTheNearerSide) {
  // Two surfaces, beams of 1 degree on each; the vehicle has moved on and sees 6 degrees between them.
  for (const double sign : {1.0, -1.0}) {
    for (const double towards : {0.3, 3.1, -3.1, -1.5}) {
      Fan fan(8, towards, sign * degree);
      fan.sweep.free_to.assign(8, 9);
      for (std::size_t i = 4; i < 8; ++i) fan.sweep.free_to[i] = 4;
      fan.move();
      for (std::size_t i = 4; i < 8; ++i) {
        const double angle = fan.angle(i) + sign * 6 * degree;
        fan.sweep.free_x[i] = static_cast<float>(4 * std::cos(angle));
        fan.sweep.free_y[i] = static_cast<float>(4 * std::sin(angle));
      }
      FreeSpaceMap map;
      fan.prepare(map);
      map.fill(fan.sweep);
      for (std::size_t cell = 0; cell < map.size(); ++cell) {
        const double place = turn_between(middle_of(map, cell), towards) / fan.step;
        if (place > 0.2 && place < 2.8) {
          EXPECT_NEAR(free_to(map, cell), 9, 0.01) << place;
        }
        if (place > 3.6 && place < 13.4) {
          EXPECT_NEAR(free_to(map, cell), 4, 0.01) << place;
        }
      }
    }
  }
}

TEST(FreeSpaceMap, DirectionsFarApartAreNoNeighboursThoughTheBeamsAre) {
  // A plane that stands nearly upright: beam by beam the direction on the ground jumps.
  for (const bool moved : {false, true}) {
    Fan fan(2, 1, 30 * degree);
    fan.sweep.free_to = {5, 5};
    fan.sweep.linked = {1, 0};
    if (moved) fan.move();
    FreeSpaceMap map;
    fan.prepare(map);
    map.fill(fan.sweep);
    const auto between = map.cell_towards(std::cos(1.26F), std::sin(1.26F));
    EXPECT_FALSE(is_free(map, between, 1)) << moved;
  }
}

// As on the ground before a plane that stands nearly upright.
TEST(FreeSpaceMap, BeamsBeyondAJumpAreFreeInTheirOwnDirections) {
  Fan fan(60, 0.3, degree);
  fan.jump = 1.5;
  fan.sweep.free_to.assign(fan.beams(), 5);
  FreeSpaceMap map;
  fan.prepare(map);
  map.fill(fan.sweep);
  for (std::size_t cell = 0; cell < map.size(); ++cell) {
    double nearest = pi_d, within = pi_d;  // within: beams with neighbours on both sides
    for (std::size_t i = 0; i < fan.beams(); ++i) {
      const double off = std::abs(turn_between(middle_of(map, cell), fan.angle(i)));
      nearest = std::min(nearest, off);
      if (i % 30 != 0 && i % 30 != 29) within = std::min(within, off);
    }
    if (within < 0.2 * degree) {
      EXPECT_TRUE(is_free(map, cell, 4)) << middle_of(map, cell);
    } else if (nearest > degree) {
      EXPECT_FALSE(is_free(map, cell, 4)) << middle_of(map, cell);
    }
  }
}

TEST(FreeSpaceMap, WhatIsNearHidesWhatIsBehindThoughItMovedAwayFromItsNeighbours) {
  Fan fan(200, -50 * degree, 0.5 * degree);
  fan.sweep.free_to.assign(fan.beams(), 20);
  fan.sweep.free_to[100] = 2;
  fan.sweep.free_from.assign(fan.beams(), 1);
  FreeSpaceMap map;
  fan.prepare(map);
  fan.move(0.5);
  map.fill(fan.sweep);
  for (const double beside : {-0.3, 0.0, 0.3}) {
    const auto angle = static_cast<float>(std::atan2(-0.5, 2) + beside * degree);
    EXPECT_FALSE(is_free(map, map.cell_towards(std::cos(angle), std::sin(angle)), 5)) << beside;
  }
  EXPECT_TRUE(is_free(map, map.cell_towards(1, 0), 10));
  EXPECT_FALSE(is_free(map, map.cell_towards(1, 0), 1.3)) << "where a way begins is known less well";
}

TEST(FreeSpaceMap, PointsAreFreeWhereTheirCellIs) {
  sim::Rng rng(5);
  Fan fan(300, -2, degree);
  fan.at = {1.5, -0.7};
  for (float& to : fan.sweep.free_to) to = static_cast<float>(1 + 5 * rng.uniform());
  FreeSpaceMap map;
  fan.prepare(map);
  map.fill(fan.sweep);
  std::vector<float> x, y;
  std::vector<FreeSpaceMap::Place> free(1000);
  for (std::size_t i = 0; i < free.size(); ++i) {
    x.push_back(static_cast<float>(16 * rng.uniform() - 8));
    y.push_back(static_cast<float>(16 * rng.uniform() - 8));
  }
  map.find_places(x.data(), y.data(), x.size(), free.data());
  std::size_t found = 0;
  for (std::size_t i = 0; i < free.size(); ++i) {
    const Eigen::Vector2d to = Eigen::Vector2d(x[i], y[i]) - fan.at;
    const double place = turn_between(std::atan2(to.y(), to.x()), fan.first + 2.6) / fan.step + 2.6 / degree;
    const double beam = std::round(place);
    if (std::abs(place - beam) > 0.4) continue;
    const bool looks = beam >= 0 && beam < 300;
    double end = looks ? static_cast<double>(fan.sweep.free_to[static_cast<std::size_t>(beam)]) : 0;
    const double beside = beam + (place < beam ? -1 : 1);
    if (std::abs(place - beam) < 0.2) continue;  // the cell's middle may lie on the beam's other side
    if (looks && beside >= 0 && beside < 300)
      end = std::min(end, static_cast<double>(fan.sweep.free_to[static_cast<std::size_t>(beside)]));
    if (std::abs(to.norm() - end) < 2 * unit) continue;
    EXPECT_EQ(map.is_free(free[i]), to.norm() < end) << i;
    EXPECT_EQ(map.is_free(map.place_of(x[i], y[i])), to.norm() < end) << i;
    found += to.norm() < end ? 1 : 0;
  }
  EXPECT_GT(found, 20U);
}

TEST(FreeSpaceMap, TheCellOfADirectionHoldsIt) {
  FreeSpaceMap map;
  map.set(3, 4, degree, unit);
  for (double angle = -pi_d + 1e-4; angle < pi_d; angle += 0.0137) {
    const std::size_t cell =
        map.cell_towards(static_cast<float>(2 * std::cos(angle)), static_cast<float>(2 * std::sin(angle)));
    EXPECT_NEAR(turn_between(middle_of(map, cell), angle), 0, pi_d / static_cast<double>(map.size()) + 1e-6);
  }
  EXPECT_EQ(map.cell_towards(-1, 0), 0) << "the last cell ends where the first one begins";
}

}  // namespace
}  // namespace lidard
