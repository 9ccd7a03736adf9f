// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Merging while the vehicle moves: every beam is brought to one instant.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/angle.h"
#include "core/merge/merger.h"
#include "test/sim/world/circle.h"
#include "test/sim/world/flat_world.h"
#include "test/sim/world/units.h"
#include "test/sim/world/vehicle_motion.h"
#include "test/support/allocations.h"

namespace lidard {
namespace {

using sim::FlatScanner;
using sim::FlatWorld;
using sim::Pose2;

Span s(double seconds) { return span_from_seconds(seconds); }

/// Where a vehicle is, s after t0.
using Motion = std::function<Pose2(double)>;

struct Drive {
  explicit Drive(Motion way) : place(std::move(way)) {}
  /// A sweep that begins `begin` s after t0 and lasts `duration`.
  PlanarScan sweep(const FlatScanner& scanner, double begin, double duration) const {
    PlanarScan scan;
    const double between = duration / static_cast<double>(std::lround(scanner.field / scanner.increment) + 1);
    sim::Rng rng(1);
    scanner.measure(
        world, [&](std::size_t i) { return place(begin + static_cast<double>(i) * between); }, rng, scan);
    scan.stamp = t0 + s(begin);
    scan.time_increment = static_cast<float>(between);
    return scan;
  }
  /// Odometry of 50 Hz.
  PoseTrack track(double from, double to) const {
    PoseTrack made;
    for (double tick = std::ceil(from * 50); tick <= to * 50; ++tick)
      made.add(t0 + s(tick / 50), sim::to_pose(place(tick / 50)));
    return made;
  }

  Motion place;
  FlatWorld world;
};

FlatScanner scanner_of(double increment_deg, double field_deg = 270) {
  FlatScanner scanner;
  scanner.increment = increment_deg * degree;
  scanner.field = field_deg * degree;
  scanner.range_max = 40;
  return scanner;
}

MergeSettings all_profiles() {
  MergeSettings settings;
  settings.visibility = true;
  settings.how.noise = settings.source.noise = 0.005;
  return settings;
}

struct TwoOutputs {
  PlanarScan strict, safety, flat;
  Cloud cloud;
  std::vector<MergedScan> list{
      {Profile::strict, &strict}, {Profile::safety, &safety}, {Profile::flatten, &flat}};
};

TEST(Deskew, StandingVehicleGivesTheVeryScanThatComesWithoutPoses) {
  Drive drive([](double) { return Pose2{3.3, -4.7, 1.234}; });
  drive.world.add_box({3, -4}, {7, 5}, 0.4);
  FlatScanner scanner = scanner_of(0.5);
  scanner.at = {1, 0.5};
  scanner.yaw = 0.3;
  TwoOutputs with, without;
  Merger merger(test::full_circle(1440, 40), {}, 1, all_profiles());
  merger.add(0, drive.sweep(scanner, 0, 0.06), scanner.pose());
  const PoseTrack track = drive.track(-0.1, 0.1);
  const MergeReport& report = merger.merge({t0 + s(0.06), &track, make_pose({0.2, 0.1, 0}, {0, 0, 0.7})}, {1},
                                           with.list, &with.cloud);
  EXPECT_EQ(report.sources[0], SourceUse::deskewed);
  merger.merge({t0 + s(0.06), nullptr}, {1}, without.list, &without.cloud);
  EXPECT_EQ(report.sources[0], SourceUse::static_poses);
  EXPECT_EQ(with.cloud.points_bytes, without.cloud.points_bytes);
  EXPECT_GT(with.cloud.size(), 400U);
  for (std::size_t i = 0; i < with.list.size(); ++i) {
    EXPECT_EQ(with.list[i].scan->statuses, without.list[i].scan->statuses);
    for (std::size_t beam = 0; beam < 1440; ++beam) {
      if (with.list[i].scan->statuses[beam] == BeamStatus::hit) {
        ASSERT_EQ(with.list[i].scan->ranges[beam], without.list[i].scan->ranges[beam]);
      }
    }
  }
}

TEST(Deskew, WallAheadStandsWhereItIsAtTheOutputsInstant) {
  // 1 m/s along x: the wall is 10 m ahead at 60 ms.
  Drive drive([](double t) { return Pose2{t - 0.06, 0, 0}; });
  drive.world.add_wall({10, -30}, {10, 30});
  FlatScanner scanner = scanner_of(0.5, 180);
  TwoOutputs out;
  Merger merger(test::full_circle(1440, 40), {}, 1, all_profiles());
  merger.add(0, drive.sweep(scanner, 0, 0.06), scanner.pose());
  const PoseTrack track = drive.track(-0.1, 0.1);
  merger.merge({t0 + s(0.06), &track}, {1}, out.list, &out.cloud);
  ASSERT_GT(out.cloud.size(), 250U);
  for (std::size_t i = 0; i < out.cloud.size(); ++i) EXPECT_NEAR(out.cloud.points()[i].x, 10, 1e-4);
  int hits = 0;
  for (std::size_t beam = 0; beam < out.strict.beams; ++beam) {
    if (out.strict.statuses[beam] != BeamStatus::hit) continue;
    ++hits;
    const double angle = test::full_circle(1440, 40).angle(beam);
    EXPECT_NEAR(out.strict.ranges[beam] * std::cos(angle), 10, 1e-3) << angle;
  }
  EXPECT_GT(hits, 500);
  EXPECT_EQ(out.strict.stamp, t0 + s(0.06));
  EXPECT_EQ(out.strict.time_increment, 0);
  // Without poses the wall leans by the way driven.
  merger.merge({t0 + s(0.06), nullptr}, {1}, out.list, &out.cloud);
  float nearest = 100, farthest = 0;
  for (std::size_t i = 0; i < out.cloud.size(); ++i) {
    nearest = std::min(nearest, out.cloud.points()[i].x);
    farthest = std::max(farthest, out.cloud.points()[i].x);
  }
  EXPECT_GT(farthest - nearest, 0.02F);
}

TEST(Deskew, WallsStayStraightAndMeetAtTheSeamWhileTheVehicleTurns) {
  // 1.7 rad/s, a full circle in 120 ms: 11.7 degrees of turn within one sweep.
  Drive drive([](double t) { return Pose2{0, 0, 1.7 * t}; });
  drive.world.add_wall({-10, -10}, {-10, 10});  // behind, where sweeps begin and end
  drive.world.add_wall({10, -10}, {10, 10});
  FlatScanner scanner = scanner_of(0.5, 359.5);
  scanner.yaw = 0;
  Merger merger(test::full_circle(1440, 40), {}, 1, all_profiles());
  merger.add(0, drive.sweep(scanner, 0, 0.12), scanner.pose());
  const PoseTrack track = drive.track(-0.1, 0.3);
  const auto worst_deviation = [&](const PoseTrack* used) {
    TwoOutputs out;
    merger.merge({t0 + s(0.12), used}, {1}, out.list, &out.cloud);
    const Eigen::Rotation2Dd back(1.7 * 0.12);
    double worst = 0;
    for (std::size_t i = 0; i < out.cloud.size(); ++i) {
      const auto& p = out.cloud.points()[i];
      const Eigen::Vector2d at = back * Eigen::Vector2d(static_cast<double>(p.x), static_cast<double>(p.y));
      worst = std::max(worst, std::abs(std::abs(at.x()) - 10));
    }
    return worst;
  };
  EXPECT_LE(worst_deviation(&track), 1e-3);
  EXPECT_GE(worst_deviation(nullptr), 1.0);
}

/// Errors of deskewed points against where the same walls are at the output's instant, m.
struct Errors {
  std::vector<double> all;
  double rms() const {
    double sum = 0;
    for (const double e : all) sum += e * e;
    return std::sqrt(sum / static_cast<double>(all.size()));
  }
  double p99() {
    std::sort(all.begin(), all.end());
    return all[all.size() * 99 / 100];
  }
};

struct Scanning {
  FlatScanner scanner;
  double period, duration, phase;
  /// Begin of the newest sweep that is complete at `time`.
  double begin_before(double time) const {
    return std::floor((time - duration - phase) / period) * period + phase;
  }
};

FlatWorld yard_along(const sim::SwingingVehicle& vehicle, sim::Rng& rng) {
  FlatWorld world;
  for (int i = 0; i < 120; ++i) {
    const Pose2 near = vehicle.at(9 * rng.uniform());
    const double away = 3 + 6 * rng.uniform(), towards = 2 * pi_d * rng.uniform();
    world.add_box({near.x + away * std::cos(towards), near.y + away * std::sin(towards)},
                  {0.1 + rng.uniform() * 0.5, 0.1 + rng.uniform() * 0.5}, 6 * rng.uniform());
  }
  return world;
}

/// A scanner of 12.5 Hz with sweeps of 60 ms and one of 40 Hz, not in step.
std::vector<Scanning> two_scanners(sim::Rng& rng) {
  std::vector<Scanning> both = {{scanner_of(0.5), 0.08, 0.06, 0.08 * rng.uniform()},
                                {scanner_of(0.25), 0.025, 0.01875, 0.025 * rng.uniform()}};
  both[0].scanner.at = {2.25, 1}, both[0].scanner.yaw = pi_d / 4;
  both[1].scanner.at = {-2.25, -1}, both[1].scanner.yaw = -3 * pi_d / 4;
  return both;
}

/// Where the things that a sweep hit are, seen from the vehicle at `now`.
void add_truth(const PlanarScan& scan, const Scanning& scanning, const sim::SwingingVehicle& vehicle,
               const Pose& now, std::vector<Eigen::Vector2d>& truth) {
  const double begin = seconds(scan.stamp - t0);
  for (std::size_t beam = 0; beam < scan.beams; ++beam) {
    if (scan.statuses[beam] != BeamStatus::hit) continue;
    const double time =
        begin + static_cast<double>(beam) * scanning.duration / static_cast<double>(scan.beams);
    const auto range = static_cast<double>(scan.ranges[beam]);
    const auto angle = static_cast<double>(scan.angle(beam));
    const Eigen::Vector3d p = now.inverse() * sim::to_pose(vehicle.at(time)) * scanning.scanner.pose() *
                              Eigen::Vector3d(range * std::cos(angle), range * std::sin(angle), 0);
    truth.emplace_back(p.head<2>());
  }
}

/// The errors of points 2 to 10 m away; odometry of 50 Hz is known until so long after each output's time.
Errors errors_while_swinging(std::uint64_t seed, double poses_until_after_end) {
  const sim::SwingingVehicle vehicle(seed, 9);
  Drive drive([&](double t) { return vehicle.at(t); });
  sim::Rng rng(seed + 1000);
  drive.world = yard_along(vehicle, rng);
  const std::vector<Scanning> both = two_scanners(rng);
  Errors errors;
  for (double end = both[0].phase + 1.5; end < 8.5; end += 0.24 + 0.01 * rng.uniform()) {
    PoseTrack track;
    vehicle.report(track, t0, 50, end - 0.5, end + poses_until_after_end);
    const double at = std::min(end, seconds(track.newest() - t0));
    Merger merger(test::full_circle(1440, 40), {}, 2);
    std::vector<Eigen::Vector2d> truth;
    for (std::size_t i = 0; i < 2; ++i) {
      const PlanarScan scan = drive.sweep(both[i].scanner, both[i].begin_before(end), both[i].duration);
      merger.add(i, scan, both[i].scanner.pose());
      add_truth(scan, both[i], vehicle, sim::to_pose(vehicle.at(at)), truth);
    }
    Cloud cloud;
    const MergeReport& report = merger.merge({t0 + s(at), &track}, {1, 1}, {}, &cloud);
    EXPECT_NE(report.sources[0], SourceUse::static_poses);
    EXPECT_EQ(cloud.size(), truth.size());
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const CloudPoint& p = cloud.points()[i];
      const Eigen::Vector2d is(static_cast<double>(p.x), static_cast<double>(p.y));
      if (truth[i].norm() >= 2 && truth[i].norm() <= 10) errors.all.push_back((is - truth[i]).norm());
    }
  }
  return errors;
}

void expect_millimetres(double poses_until_after_end) {
  Errors all;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const Errors errors = errors_while_swinging(seed, poses_until_after_end);
    all.all.insert(all.all.end(), errors.all.begin(), errors.all.end());
  }
  ASSERT_GT(all.all.size(), 50'000U);
  testing::Test::RecordProperty("rms_mm", std::to_string(all.rms() * 1000));
  testing::Test::RecordProperty("p99_mm", std::to_string(all.p99() * 1000));
  EXPECT_LE(all.rms(), 0.001);
  EXPECT_LE(all.p99(), 0.003);
}

TEST(Deskew, PointsAreExactToAMillimetreWhileTheVehicleSwings) { expect_millimetres(0.02); }

TEST(Deskew, PointsAreExactToAMillimetreAlsoWhenTheNewestPoseIsOlderThanTheSweepsEnd) {
  expect_millimetres(0);
}

}  // namespace
}  // namespace lidard
