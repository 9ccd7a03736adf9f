// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// What a merge does if it is told to: conflicts, heights, the cross-check of veils, intensities.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/angle.h"
#include "core/merge/merger.h"
#include "test/sim/world/flat_world.h"
#include "test/sim/world/units.h"
#include "test/support/allocations.h"

namespace lidard {
namespace {

using sim::FlatScanner;
using sim::FlatWorld;

FlatWorld room() {
  FlatWorld world;
  world.add_box({0, 0}, {12, 9}, 0);
  return world;
}
FlatWorld room_with_box() {
  FlatWorld world = room();
  world.add_box({5, 0}, {0.4, 0.4}, 0);
  return world;
}

/// Two scanners on the front corners of a vehicle, 0.5 degrees between beams.
class Vehicle {
 public:
  explicit Vehicle(const MergeOptions& options, double range_max = 20) {
    ScanGridSpec spec;
    spec.beams = 720;
    spec.range_max = range_max;
    MergeSettings settings;
    settings.points = false;
    settings.visibility = true;
    settings.source.veil_filter = false;
    settings.options = options;
    merger.emplace(make_grid(spec).value(), HeightBand(), 2, settings);
    merger->set_footprint(Footprint({{-4, -1}, {0, -1}, {0, 1}, {-4, 1}}));
  }
  static FlatScanner scanner(std::size_t index) {
    FlatScanner scanner;
    const double side = index == 0 ? 1 : -1;
    scanner.at = {0, side};
    scanner.yaw = side * pi_d / 4;
    scanner.increment = 0.5 * degree;
    scanner.range_max = 60;
    return scanner;
  }
  static PlanarScan measured(std::size_t index, const FlatWorld& world, Stamp stamp) {
    sim::Rng rng(1);
    PlanarScan scan;
    scanner(index).measure(world, rng, scan);
    scan.stamp = stamp;
    return scan;
  }
  void add(std::size_t index, const PlanarScan& scan, double height = 0.3) {
    Pose pose = scanner(index).pose();
    pose.translation().z() = height;
    ASSERT_TRUE(merger->add(index, scan, pose));
  }
  void merge() {
    MergeMoment moment;
    moment.at = t0;
    merger->merge(moment, {1, 1}, {{Profile::strict, &strict}, {Profile::safety, &safety}}, nullptr);
  }
  /// Beams within 3 degrees of straight ahead that end nearer than the far wall.
  static long on_the_box(const PlanarScan& scan) {
    long count = 0;
    for (std::size_t i = 0; i < scan.beams; ++i)
      count += std::abs(scan.angle(i)) < static_cast<float>(3 * degree) && scan.ranges[i] < 6 ? 1 : 0;
    return count;
  }
  static long free_beams(const PlanarScan& scan) {
    return std::count(scan.statuses.begin(), scan.statuses.end(), BeamStatus::none);
  }

  std::optional<Merger> merger;
  PlanarScan strict, safety;
};

MergeOptions newest_wins() {
  MergeOptions options;
  options.newest_wins = true;
  return options;
}

TEST(MergeOptions, OlderHitInsideNewerFreeSpaceIsKeptUnlessTheNewestWins) {
  for (const bool newest : {false, true}) {
    Vehicle vehicle(newest ? newest_wins() : MergeOptions());
    vehicle.add(0, Vehicle::measured(0, room_with_box(), t0));
    vehicle.add(1, Vehicle::measured(1, room(), t0 + ms(20)));
    vehicle.merge();
    if (newest) {
      EXPECT_EQ(Vehicle::on_the_box(vehicle.strict), 0);
      EXPECT_EQ(Vehicle::on_the_box(vehicle.safety), 0);
      EXPECT_GT(vehicle.merger->cross_check()->conflicts(), 5U);
    } else {
      EXPECT_GE(Vehicle::on_the_box(vehicle.strict), 10);
      EXPECT_EQ(vehicle.merger->cross_check(), nullptr);
    }
  }
}

TEST(MergeOptions, NewerHitInsideOlderFreeSpaceStaysThoughTheNewestWins) {
  Vehicle vehicle(newest_wins());
  vehicle.add(0, Vehicle::measured(0, room_with_box(), t0 + ms(20)));
  vehicle.add(1, Vehicle::measured(1, room(), t0));
  vehicle.merge();
  EXPECT_GE(Vehicle::on_the_box(vehicle.strict), 10);
  EXPECT_EQ(vehicle.merger->cross_check()->conflicts(), 0U);
}

TEST(MergeOptions, NothingThatStandsIsLostWhereSourcesAgree) {
  MergeOptions options = newest_wins();
  options.veil_cross_check = true;
  Vehicle checked(options);
  Vehicle plain{MergeOptions()};
  for (Vehicle* vehicle : {&checked, &plain}) {
    vehicle->add(0, Vehicle::measured(0, room_with_box(), t0));
    vehicle->add(1, Vehicle::measured(1, room_with_box(), t0 + ms(10)));
    vehicle->merge();
  }
  EXPECT_EQ(checked.merger->cross_check()->veils(), 0U);
  EXPECT_EQ(checked.merger->cross_check()->conflicts(), 0U);
  EXPECT_EQ(checked.strict.statuses, plain.strict.statuses);
  EXPECT_EQ(checked.safety.statuses, plain.safety.statuses);
}

TEST(MergeOptions, ReturnThatAnotherSourceSeesThroughIsLeftToSafety) {
  for (const bool cross_check : {false, true}) {
    MergeOptions options;
    options.veil_cross_check = cross_check;
    Vehicle vehicle(options);
    PlanarScan with_veil = Vehicle::measured(0, room(), t0);
    const std::size_t beam = with_veil.beams / 2 - 90;  // straight ahead
    with_veil.set_hit(beam, 5);
    vehicle.add(0, with_veil);
    vehicle.add(1, Vehicle::measured(1, room(), t0));
    vehicle.merge();
    const auto nearer = [](const PlanarScan& scan) {
      return std::count_if(scan.ranges.begin(), scan.ranges.end(), [](float r) { return r < 6; });
    };
    const auto walls = nearer(vehicle.safety) - 1;
    EXPECT_EQ(nearer(vehicle.strict), cross_check ? walls : walls + 1);
    if (cross_check) {
      EXPECT_EQ(vehicle.merger->cross_check()->veils(), 1U);
    }
  }
}

TEST(MergeOptions, ChecksDoNotAllocateOnceTheyAreWarm) {
  MergeOptions options = newest_wins();
  options.veil_cross_check = options.all_heights = true;
  Vehicle vehicle(options);
  const PlanarScan left = Vehicle::measured(0, room_with_box(), t0);
  const PlanarScan right = Vehicle::measured(1, room(), t0 + ms(20));
  vehicle.add(0, left, 0.3);
  vehicle.add(1, right, 1.2);
  for (int i = 0; i < 3; ++i) vehicle.merge();
  const std::size_t before = test::allocations();
  vehicle.merge();
  EXPECT_LE(test::allocations() - before, 3U);  // the list of outputs and that of sources, in the test
}

/// Free beams in an open field with the right scanner at `height`, the left one at 0.3 m.
long free_in_a_field(bool all_heights, double height, bool both = true) {
  MergeOptions options;
  options.all_heights = all_heights;
  Vehicle vehicle(options, 15);
  vehicle.add(0, Vehicle::measured(0, FlatWorld(), t0), 0.3);
  if (both) vehicle.add(1, Vehicle::measured(1, FlatWorld(), t0), height);
  vehicle.merge();
  return Vehicle::free_beams(vehicle.strict);
}

TEST(MergeOptions, BeamIsFreeOnlyWhereEveryHeightSeesItIfThatIsAskedFor) {
  const long any = free_in_a_field(false, 1.2);
  const long one_height = free_in_a_field(true, 0.35);
  const long two_heights = free_in_a_field(true, 1.2);
  EXPECT_GT(any, 650);
  EXPECT_EQ(one_height, any);
  // 270 degrees each, turned by 45 to either side: both see 180 degrees ahead.
  EXPECT_NEAR(static_cast<double>(two_heights), 360, 25);
}

TEST(MergeOptions, NothingIsFreeWhileASourceOfUnknownHeightIsMissing) {
  EXPECT_GT(free_in_a_field(false, 1.2, false), 400);
  EXPECT_EQ(free_in_a_field(true, 1.2, false), 0);
}

/// Intensities of a merge of a scan with 100 everywhere and one without.
std::vector<float> intensities(Intensities choice, Profile profile) {
  MergeSettings settings;
  settings.points = settings.visibility = true;
  settings.options.intensities = choice;
  settings.options.missing_intensity = 7;
  ScanGridSpec spec;
  spec.beams = 720;
  spec.range_max = 20;
  Merger merger(make_grid(spec).value(), {}, 2, settings);
  for (const std::size_t s : {0U, 1U}) {
    PlanarScan scan = Vehicle::measured(s, room(), t0);
    if (s == 1) scan.intensities.clear();
    EXPECT_TRUE(merger.add(s, scan, Vehicle::scanner(s).pose()));
  }
  PlanarScan merged;
  MergeMoment moment;
  moment.at = t0;
  merger.merge(moment, {1, 1}, {{profile, &merged}}, nullptr);
  return merged.intensities;
}

TEST(MergeOptions, IntensitiesAreLeftOutUnlessAllSourcesHaveThemOrTheyAreWanted) {
  for (const Profile profile : {Profile::flatten, Profile::strict}) {
    EXPECT_TRUE(intensities(Intensities::automatic, profile).empty());
    EXPECT_TRUE(intensities(Intensities::off, profile).empty());
    const auto filled = intensities(Intensities::on, profile);
    ASSERT_EQ(filled.size(), 720U);
    EXPECT_GT(std::count(filled.begin(), filled.end(), 100.0F), 100);
    EXPECT_GT(std::count(filled.begin(), filled.end(), 7.0F), 50);
  }
}

}  // namespace
}  // namespace lidard
