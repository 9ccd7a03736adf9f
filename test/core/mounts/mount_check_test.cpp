// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/mounts/mount_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "core/base/angle.h"
#include "test/sim/world/flat_world.h"
#include "test/sim/world/units.h"
#include "test/support/allocations.h"

namespace lidard {
namespace {

using sim::FlatScanner;
using sim::FlatWorld;

/// How a scanner is mounted against what the configuration says.
struct MountError {
  double yaw_deg = 0, x = 0, y = 0;
};

/// Two 270 degree scanners on the front corners of a vehicle; the right one may be mounted wrongly.
struct CheckedVehicle {
  explicit CheckedVehicle(const FlatWorld& surroundings, double range_noise = 0.01) : world(surroundings) {
    for (const double side : {1.0, -1.0}) {
      FlatScanner scanner;
      scanner.at = {0, side};
      scanner.yaw = side * 45 * degree;
      scanner.increment = 0.5 * degree;
      scanner.noise = range_noise;
      configured.push_back(scanner);
    }
    settings.noise = std::max(range_noise, 0.001);
  }

  /// Looks from `begin` s on for `length` s, a sweep each `period` s; the state at the end.
  const MountDifference& drive(const MountError& error, double begin, double length) {
    for (double t = begin; t < begin + length; t += period) {
      for (std::size_t s = 0; s < 2; ++s) {
        FlatScanner real = configured[s];
        if (s == 1) {
          real.yaw += error.yaw_deg * degree;
          real.at += Eigen::Vector2d(error.x, error.y);
        }
        real.at.x() += speed * (t + 0.02 * static_cast<double>(s));
        PlanarScan scan;
        real.measure(s == 1 && seen_by_second ? *seen_by_second : world, rng, scan);
        BeamRays rays;
        rays.build(scan, configured[s].pose(), {}, {});
        condition(scan, rays, settings, sweeps[s]);
      }
      const Stamp stamp{1'000'000'000 + static_cast<std::int64_t>(t * 1e9)};
      if (check.is_due(stamp)) check.update(stamp, {&sweeps[0], &sweeps[1]}, {{0, 1}, {0, -1}}, deskewed);
    }
    return check.pairs().at(0);
  }

  FlatWorld world;
  std::optional<FlatWorld> seen_by_second;  // if it is not the same, as from another height
  std::vector<FlatScanner> configured;
  SourceSettings settings;
  double speed = 0;      // m/s; the second scanner measures 20 ms after the first
  double period = 0.04;  // s
  bool deskewed = false;
  sim::Rng rng{7};
  PlacedScan sweeps[2];
  MountCheck check{2};
};

/// The room of the paper on ira_laser_tools: 40 x 24 m, a box before the vehicle.
FlatWorld paper_room() {
  FlatWorld world;
  world.add_box({0, 0}, {20, 12}, 0);
  world.add_box({2.5, 0}, {0.5, 0.5}, 0);
  return world;
}

void expect_correction(const MountDifference& state, const MountError& error) {
  EXPECT_NEAR(state.correction[2] / degree, error.yaw_deg, 0.05);
  EXPECT_NEAR(state.correction[0], error.x, 0.005);
  EXPECT_NEAR(state.correction[1], error.y, 0.005);
  EXPECT_TRUE(state.determined[0] && state.determined[1] && state.determined[2]);
}

TEST(MountCheck, ScannersMountedAsConfiguredAgree) {
  for (const double noise : {0.0, 0.01, 0.02}) {
    CheckedVehicle vehicle(paper_room(), noise);
    const MountDifference& state = vehicle.drive({}, 0, 5);
    EXPECT_GE(state.surfaces, 2) << noise;
    EXPECT_FALSE(state.is_wrong) << noise;
    expect_correction(state, {});
  }
}

TEST(MountCheck, FindsAMountTurnedByHalfADegreeWithinTenSeconds) {
  for (const double noise : {0.0, 0.01, 0.02}) {
    for (const double yaw : {0.5, -0.5}) {
      CheckedVehicle vehicle(paper_room(), noise);
      const MountDifference& state = vehicle.drive({yaw, 0, 0}, 0, 9);
      EXPECT_TRUE(state.is_wrong) << noise << ' ' << yaw;
      expect_correction(state, {yaw, 0, 0});
    }
  }
}

TEST(MountCheck, FindsAMountShiftedByThreeCentimetresWithinTenSeconds) {
  for (const MountError& error :
       {MountError{0, 0.03, 0}, MountError{0, 0, -0.03}, MountError{0.4, -0.05, 0.05}}) {
    CheckedVehicle vehicle(paper_room());
    const MountDifference& state = vehicle.drive(error, 0, 9);
    EXPECT_TRUE(state.is_wrong) << error.x << ' ' << error.y;
    expect_correction(state, error);
  }
}

TEST(MountCheck, FindsAMountThatIsFarFromWhatIsConfigured) {
  for (const MountError& error : {MountError{6, 0, 0}, MountError{-8, 0.1, 0}, MountError{12, 0, 0},
                                  MountError{-25, 0, 0}, MountError{0, 0.6, 0}, MountError{0, -0.3, 0.9}}) {
    CheckedVehicle vehicle(paper_room());
    const MountDifference& state = vehicle.drive(error, 0, 9);
    EXPECT_TRUE(state.is_wrong) << error.yaw_deg << ' ' << error.x;
    EXPECT_FALSE(state.is_astray);
    expect_correction(state, error);
    EXPECT_FALSE(vehicle.drive({}, 9, 8).is_wrong) << "it was corrected";
    expect_correction(state, {});
  }
}

TEST(MountCheck, FindsAMountThatIsFarAlsoByTwoWallsAlone) {
  FlatWorld corner;
  corner.add_wall({6, -7}, {6, 8});
  corner.add_wall({-6, 7}, {8, 7});
  for (const double yaw_deg : {4.0, 6.0, -8.0, 15.0}) {
    CheckedVehicle vehicle(corner);
    const MountDifference& state = vehicle.drive({yaw_deg, 0, 0}, 0, 9);
    EXPECT_TRUE(state.is_wrong) << yaw_deg;
    expect_correction(state, {yaw_deg, 0, 0});
  }
}

TEST(MountCheck, SaysThatAScannerSeesNothingOfWhatTheOtherOneSees) {
  for (const double yaw_deg : {45.0, 70.0, -90.0, 130.0}) {
    CheckedVehicle vehicle(paper_room());
    EXPECT_FALSE(vehicle.drive({yaw_deg, 0, 0}, 0, 4).is_astray) << "for a moment";
    const MountDifference& state = vehicle.drive({yaw_deg, 0, 0}, 4, 5);
    EXPECT_TRUE(state.is_astray) << yaw_deg;
    EXPECT_FALSE(state.is_wrong) << "no correction is known";
    EXPECT_FALSE(vehicle.drive({}, 9, 2).is_astray);
  }
}

TEST(MountCheck, IsSilentWhereTheOtherScannerLooksOverHalfOfTheThings) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    for (const bool walled : {true, false}) {
      sim::Rng random(seed);
      const auto between = [&](double low, double high) { return low + (high - low) * random.uniform(); };
      FlatWorld low, high;
      for (FlatWorld* world : {&low, &high})
        if (walled) world->add_box({0, 0}, {15, 11}, 0.2);
      for (int i = 0; i < 20; ++i) {
        const Eigen::Vector2d at(between(-14, 14), between(-10, 10)),
            half(between(0.2, 1.5), between(0.2, 1.5));
        const double yaw = between(0, 3);
        if (at.norm() < 4) continue;
        low.add_box(at, half, yaw);
        if (i % 2 == 0) high.add_box(at, half, yaw);
      }
      CheckedVehicle vehicle(low, 0.015);
      vehicle.seen_by_second = high;
      const MountDifference& state = vehicle.drive({}, 0, 9);
      EXPECT_FALSE(state.is_wrong || state.is_astray) << seed << ' ' << walled;
    }
  }
}

TEST(MountCheck, NoticesAMountThatIsKnockedOnTheWay) {
  CheckedVehicle vehicle(paper_room());
  EXPECT_FALSE(vehicle.drive({}, 0, 10).is_wrong);
  const MountDifference state = vehicle.drive({1.0, 0, 0}, 10, 9);
  EXPECT_TRUE(state.is_wrong);
  EXPECT_NEAR(state.correction[2] / degree, 1, 0.05) << "what was seen before the knock is forgotten";
  EXPECT_NEAR(seconds(state.since.value_or(Stamp{}) - Stamp{1'000'000'000}), 10.1, 0.3)
      << "the first look that shows it";
  EXPECT_FALSE(vehicle.drive({}, 19, 5).since);
}

TEST(MountCheck, NoticesAKnockedMountOfAnOutputThatIsRare) {
  CheckedVehicle vehicle(paper_room());
  vehicle.period = 3;
  EXPECT_FALSE(vehicle.drive({}, 0, 30).is_wrong);
  EXPECT_TRUE(vehicle.drive({1.0, 0, 0}, 30, 30).is_wrong);
}

TEST(MountCheck, MotionThatIsNotKnownIsNotTakenForAWrongMount) {
  CheckedVehicle vehicle(paper_room());
  vehicle.speed = 1.5;
  EXPECT_FALSE(vehicle.drive({}, 0, 4).is_wrong);
  EXPECT_EQ(vehicle.drive({}, 4, 0.3).surfaces, 0);
  vehicle.speed = 0;
  EXPECT_TRUE(vehicle.drive({0.5, 0, 0}, 5, 9).is_wrong);
}

TEST(MountCheck, ComparesAlsoWhileDrivingOnceSweepsAreDeskewed) {
  CheckedVehicle vehicle(paper_room());
  vehicle.deskewed = true;
  expect_correction(vehicle.drive({0.5, 0, 0}, 0, 2), {0.5, 0, 0});
}

TEST(MountCheck, InACorridorItDoesNotGuessHowFarAlongOneIs) {
  FlatWorld corridor;
  corridor.add_wall({-60, 2}, {60, 2});
  corridor.add_wall({-60, -2}, {60, -2});
  CheckedVehicle vehicle(corridor);
  const MountDifference& state = vehicle.drive({0.5, 0.05, 0.05}, 0, 9);
  EXPECT_TRUE(state.is_wrong);
  EXPECT_NEAR(state.correction[2] / degree, 0.5, 0.05);
  EXPECT_FALSE(state.determined[0]);
  EXPECT_TRUE(state.determined[1] && state.determined[2]);
  EXPECT_NEAR(state.correction[1], 0.05, 0.01);
  EXPECT_NEAR(state.correction[0], 0, 0.005);
}

TEST(MountCheck, SaysNothingWhereTheScannersHaveNothingInCommon) {
  CheckedVehicle vehicle(FlatWorld{});
  const MountDifference& state = vehicle.drive({2, 0, 0}, 0, 1);
  EXPECT_EQ(state.surfaces, 0);
  EXPECT_FALSE(state.is_wrong);
}

TEST(MountCheck, AWallThatOneScannerAloneSeesIsNotComparedWithTheOneBehindIt) {
  // Each scanner has a box close in front of it that hides what the other one sees.
  FlatWorld world;
  world.add_box({0, 0}, {12, 10}, 0);
  for (const double side : {1.0, -1.0}) world.add_box({1.2, side * 1.3}, {0.1, 0.4}, 0);
  CheckedVehicle vehicle(world);
  const MountDifference& state = vehicle.drive({}, 0, 2);
  EXPECT_FALSE(state.is_wrong);
}

TEST(MountCheck, LooksFiveTimesASecondAndStartsAnewWhenTheInputDoes) {
  MountCheck check(2);
  const Stamp t{5'000'000'000};
  EXPECT_TRUE(check.is_due(t));
  check.update(t, {nullptr, nullptr}, {{0, 0}, {0, 0}}, false);
  EXPECT_FALSE(check.is_due(t + std::chrono::milliseconds(199)));
  EXPECT_TRUE(check.is_due(t + std::chrono::milliseconds(200)));
  EXPECT_TRUE(check.is_due(t - std::chrono::seconds(2)));
}

/// Two scanners in a room, some of which stand elsewhere at every other look, by 0.1 m or by `turn` rad.
std::size_t surfaces_compared(bool first_moves, bool second_moves, bool deskewed, double turn = 0) {
  CheckedVehicle vehicle(paper_room(), 0.001);
  std::size_t surfaces = 0;
  for (int look = 0; look < 8; ++look) {
    for (std::size_t s = 0; s < 2; ++s) {
      FlatScanner scanner = vehicle.configured[s];
      const bool moves = (s == 0 ? first_moves : second_moves) && look % 2 == 1;
      if (moves && turn == 0) scanner.at.x() += 0.1;
      if (moves) scanner.yaw += turn;
      PlanarScan scan;
      scanner.measure(vehicle.world, vehicle.rng, scan);
      BeamRays rays;
      rays.build(scan, vehicle.configured[s].pose(), {}, {});
      condition(scan, rays, vehicle.settings, vehicle.sweeps[s]);
    }
    const Stamp stamp{1'000'000'000 + look * 200'000'000LL};
    vehicle.check.update(stamp, {&vehicle.sweeps[0], &vehicle.sweeps[1]}, {{0, 1}, {0, -1}}, deskewed);
    surfaces = vehicle.check.pairs().at(0).surfaces;
  }
  return surfaces;
}

TEST(MountCheck, IsNotFooledWhileOneScannerMovesThoughTheOtherOneStands) {
  EXPECT_GT(surfaces_compared(false, false, false), 2);
  EXPECT_EQ(surfaces_compared(true, false, false), 0);
  EXPECT_EQ(surfaces_compared(false, true, false), 0);
  EXPECT_EQ(surfaces_compared(true, true, false), 0);
  EXPECT_GT(surfaces_compared(true, true, true), 2) << "deskewed sweeps may be compared always";
  for (const double turn : {-0.5, 0.5})
    EXPECT_EQ(surfaces_compared(true, false, false, turn * degree), 0) << turn;
}

TEST(MountCheck, MotionOfLessThanThreeCentimetresFromLookToLookIsStanding) {
  for (const double speed : {0.1, 0.2}) {
    CheckedVehicle vehicle(paper_room(), 0.001);
    vehicle.speed = speed;  // 2 and 4 cm a look
    EXPECT_EQ(vehicle.drive({}, 0, 2).surfaces > 0, speed < 0.15) << speed;
  }
}

TEST(MountCheck, TellsWhichOfThreeScannersIsMountedWronglyAndHowFarOff) {
  FlatWorld world = paper_room();
  world.add_box({-7, 5}, {1, 2}, 0.4);
  const std::vector<Eigen::Vector2d> places = {{0, 1}, {0, -1}, {-2, 0.3}};
  MountCheck check(3);
  std::vector<PlacedScan> sweeps(3);
  sim::Rng rng(3);
  for (int look = 0; look < 40; ++look) {
    for (std::size_t s = 0; s < 3; ++s) {
      FlatScanner scanner;
      scanner.at = places[s];
      scanner.field = 350 * degree;
      scanner.increment = 0.5 * degree;
      scanner.noise = 0.005;
      const Pose configured = scanner.pose();
      if (s == 2) scanner.yaw = 1 * degree, scanner.at += Eigen::Vector2d(0.04, -0.03);
      PlanarScan scan;
      scanner.measure(world, rng, scan);
      BeamRays rays;
      rays.build(scan, configured, {}, {});
      SourceSettings settings;
      settings.noise = 0.005;
      condition(scan, rays, settings, sweeps[s]);
    }
    check.update(Stamp{1'000'000'000 + look * 200'000'000LL}, {&sweeps[0], &sweeps[1], &sweeps[2]}, places,
                 false);
  }
  ASSERT_EQ(check.pairs().size(), 3U);
  for (const MountDifference& pair : check.pairs()) {
    const bool wrong = pair.second == 2;
    EXPECT_EQ(pair.is_wrong, wrong) << pair.first << ' ' << pair.second;
    expect_correction(pair, wrong ? MountError{1, 0.04, -0.03} : MountError{});
    if (wrong) {
      EXPECT_EQ(check.wrong_source(), 2U);
    }
  }
  check.reset();
  for (const MountDifference& pair : check.pairs()) {
    EXPECT_EQ(pair.surfaces, 0);
    EXPECT_FALSE(pair.is_wrong);
    EXPECT_LT(pair.first, pair.second) << "which sources it is about stays";
  }
  EXPECT_TRUE(check.is_due(Stamp{1}));
}

TEST(MountCheck, AJumpBackOfMoreThanASecondForgetsWhatWasSeen) {
  CheckedVehicle vehicle(paper_room());
  ASSERT_TRUE(vehicle.drive({1, 0, 0}, 10, 6).is_wrong);
  const std::size_t before = vehicle.check.pairs()[0].surfaces;
  ASSERT_GT(before, 0);
  const Stamp newest{1'000'000'000 + 15'960'000'000};
  EXPECT_FALSE(vehicle.check.is_due(newest - std::chrono::milliseconds(900)));
  vehicle.check.update(newest - std::chrono::milliseconds(900), {nullptr, nullptr}, {{0, 1}, {0, -1}}, false);
  EXPECT_EQ(vehicle.check.pairs()[0].surfaces, before);
  EXPECT_TRUE(vehicle.check.is_due(newest - std::chrono::milliseconds(2000)));
  vehicle.check.update(newest - std::chrono::milliseconds(2000), {nullptr, nullptr}, {{0, 1}, {0, -1}},
                       false);
  EXPECT_EQ(vehicle.check.pairs()[0].surfaces, 0);
  EXPECT_FALSE(vehicle.check.pairs()[0].is_wrong);
}

TEST(MountCheck, ADifferenceBelowTheToleranceOrOfAFewSecondsIsNoWarning) {
  for (const MountError& error : {MountError{0.2, 0, 0}, MountError{0, 0.01, -0.005}}) {
    CheckedVehicle vehicle(paper_room());
    EXPECT_FALSE(vehicle.drive(error, 0, 20).since) << error.yaw_deg;
  }
  CheckedVehicle vehicle(paper_room());
  vehicle.drive({}, 0, 10);
  EXPECT_FALSE(vehicle.drive({2, 0.1, 0}, 10, 4).is_wrong);
  EXPECT_FALSE(vehicle.drive({}, 14, 4).since);
}

TEST(MountCheck, CurvesAreNoSurfacesThatCouldBeCompared) {
  for (const double radius : {3.5, 8.0, 20.0}) {
    FlatWorld silo;
    for (int i = 0; i < 720; ++i) {
      const double a = two_pi * i / 720, b = two_pi * (i + 1) / 720;
      silo.add_wall({1.5 + radius * std::cos(a), 0.7 + radius * std::sin(a)},
                    {1.5 + radius * std::cos(b), 0.7 + radius * std::sin(b)});
    }
    CheckedVehicle vehicle(silo);
    EXPECT_FALSE(vehicle.drive({}, 0, 20).since) << radius;
  }
}

TEST(MountCheck, IsSilentInYardsWithPeopleWhoWalkThere) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    sim::Rng random(seed);
    const auto between = [&](double low, double high) { return low + (high - low) * random.uniform(); };
    FlatWorld yard;
    yard.add_box({0, 0}, {between(10, 17), between(8, 14)}, between(-0.3, 0.3));
    for (int i = 0; i < 12; ++i) {
      const Eigen::Vector2d at(between(-15, 15), between(-12, 12));
      if (at.norm() > 4) yard.add_box(at, {between(0.2, 1.5), between(0.2, 1.5)}, between(0, 3));
    }
    CheckedVehicle vehicle(yard, 0.015);
    for (int step = 0; step < 50; ++step) {
      vehicle.world = yard;
      for (int person = 0; person < 5; ++person) {
        const double a = 1.3 * person + 0.08 * step;
        vehicle.world.add_box({(3.0 + person) * std::cos(a), (3.0 + person) * std::sin(a)}, {0.3, 0.2}, a);
      }
      EXPECT_FALSE(vehicle.drive({}, 0.4 * step, 0.4).is_wrong) << seed;
    }
    EXPECT_TRUE(vehicle.drive({-0.5, 0, 0}, 20, 9.5).is_wrong) << seed;
  }
}

TEST(MountCheck, DoesNotAllocateAfterItsFirstLook) {
  CheckedVehicle vehicle(paper_room());
  vehicle.drive({}, 0, 0.3);
  const std::vector<const PlacedScan*> sweeps = {&vehicle.sweeps[0], &vehicle.sweeps[1]};
  const std::vector<Eigen::Vector2d> places = {{0, 1}, {0, -1}};
  const Stamp later{9'000'000'000};
  const auto before = test::allocations();
  vehicle.check.update(later, sweeps, places, true);
  EXPECT_EQ(test::allocations(), before);
}

}  // namespace
}  // namespace lidard
