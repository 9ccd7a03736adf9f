// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "core/base/angle.h"
#include "core/evidence/placed_scan.h"
#include "test/sim/world/rng.h"
#include "test/sim/world/units.h"
#include "test/sim/world/vehicle_motion.h"

namespace lidard {
namespace {

constexpr Stamp start{1'700'000'000'000'000'000};

/// A scanner mounted in any way: level, tilted, upside down.
Pose random_mount(sim::Rng& rng) {
  const double roll = rng.uniform() < 0.5 ? 0 : pi_d;
  return make_pose({rng.within(2), rng.within(2), rng.uniform()},
                   {roll + rng.within(0.2), rng.within(0.2), rng.within(3)});
}

PlanarScan random_scan(sim::Rng& rng, std::size_t echoes = 1) {
  PlanarScan scan;
  scan.reset(181, echoes, true);
  scan.set_angles(static_cast<float>(-135 * degree), static_cast<float>(1.5 * degree));
  if (rng.uniform() < 0.3)
    scan.set_angles(static_cast<float>(135 * degree), static_cast<float>(-1.5 * degree));
  scan.range_max = 30;
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    scan.intensities[i] = static_cast<float>(std::floor(1 + 200 * rng.uniform()));
    if (rng.uniform() < 0.7)
      scan.set_hit(i, static_cast<float>(1 + 20 * rng.uniform()));
    else
      scan.set_without_hit(i, rng.uniform() < 0.5 ? BeamStatus::none : BeamStatus::invalid);
  }
  return scan;
}

/// How the vehicle moves during a sweep, and the exact transforms for it.
struct Drive {
  explicit Drive(std::uint64_t seed, const Pose& output_from_base_pose)
      : vehicle(seed, 2), output_from_base(output_from_base_pose) {
    vehicle.report(track, start, 200, 0.4, 1.4);
  }
  /// What was measured at `point` of the output frame, `time` s after the start, in that frame at 1.2 s.
  Eigen::Vector3d now(const Eigen::Vector3d& point, double time) const {
    const Pose base_now = sim::to_pose(vehicle.at(1.2)), base_then = sim::to_pose(vehicle.at(time));
    return output_from_base * (base_now.inverse() * base_then) * (output_from_base.inverse() * point);
  }
  MergeMoment moment() const { return {start + span_from_seconds(1.2), &track, output_from_base}; }

  sim::SwingingVehicle vehicle;
  Pose output_from_base;
  PoseTrack track;
};

/// The part of a beam that lies at heights that count, and m of it that are free; none: nothing.
struct Way {
  double begin, end;  // m along the beam
};
std::optional<Way> way_in_band(const Pose& mount, const Eigen::Vector3d& ray, HeightBand band, double to) {
  double begin = 0, end = to;
  const double from = mount.translation().z();
  if (std::abs(ray.z()) < 1e-9) {
    if (from < band.min || from > band.max) return std::nullopt;
  } else {
    const double a = (band.min - from) / ray.z(), b = (band.max - from) / ray.z();
    begin = std::max(begin, std::min(a, b));
    end = std::min(end, std::max(a, b));
  }
  if (end <= begin) return std::nullopt;
  return Way{begin, end};
}

/// A random sweep of a random mount on a vehicle that drives or stands.
struct DrivenSweep {
  explicit DrivenSweep(std::uint64_t seed)
      : rng(seed),
        drive(seed, make_pose({rng.within(1), rng.within(1), rng.within(0.5)}, {0, 0, rng.within(3)})),
        mount(random_mount(rng)),
        scan(random_scan(rng)),
        moves(seed % 4 != 0) {
    scan.stamp = start + span_from_seconds(1.1);
    scan.time_increment = 0.06F / 180;
    SourceSettings settings;
    settings.veil_filter = false;
    BeamRays rays;
    rays.build(scan, mount, {}, band);
    SweepMotion motion;
    if (moves) {
      EXPECT_NE(motion.follow(drive.moment(), times_of(scan)), PoseOrigin::missing);
    }
    measure(scan, rays, settings, placed);
    transform(rays, motion, settings.noise, placed);
  }
  Eigen::Vector3d ray(std::size_t beam) const {
    const auto angle = static_cast<double>(scan.angle_min) +
                       static_cast<double>(beam) * static_cast<double>(scan.angle_increment);
    return mount.linear() * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
  }
  /// Of a point on a beam, as seen from now.
  Eigen::Vector3d place_of(std::size_t beam, double range) const {
    const Eigen::Vector3d then = mount.translation() + range * ray(beam);
    return moves ? drive.now(then, 1.1 + 0.06 / 180 * static_cast<double>(beam)) : then;
  }
  /// m along the beam, as far as it proves anything.
  double length(std::size_t beam) const {
    return scan.statuses[beam] == BeamStatus::hit    ? static_cast<double>(scan.ranges[beam])
           : scan.statuses[beam] == BeamStatus::none ? 30
                                                     : 0;
  }

  sim::Rng rng;
  Drive drive;
  Pose mount;
  HeightBand band{-1, 2};
  PlanarScan scan;
  bool moves;
  PlacedScan placed;
};

TEST(PlacedScanMotion, ReturnsOfATurnedMountAreWhereTheyWereMeasuredAsSeenFromNow) {
  std::size_t moved = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const DrivenSweep sweep(seed);
    ASSERT_EQ(sweep.placed.moved, sweep.moves);
    for (std::size_t i = 0; i < sweep.scan.beams; ++i) {
      const double to = sweep.length(i);
      const double height = sweep.mount.translation().z() + to * sweep.ray(i).z();
      if (std::abs(height - sweep.band.min) < 1e-4 || std::abs(height - sweep.band.max) < 1e-4) continue;
      const bool counts =
          sweep.scan.statuses[i] == BeamStatus::hit && height >= sweep.band.min && height <= sweep.band.max;
      ASSERT_EQ(sweep.placed.kind[i] == Return::surface, counts) << seed << ' ' << i;
      if (!counts) continue;
      const Eigen::Vector3d at = sweep.place_of(i, to);
      ASSERT_NEAR(static_cast<double>(sweep.placed.x[i]), at.x(), 8e-4) << seed << ' ' << i;
      ASSERT_NEAR(static_cast<double>(sweep.placed.y[i]), at.y(), 8e-4) << seed << ' ' << i;
      moved += sweep.moves ? 1 : 0;
    }
  }
  EXPECT_GT(moved, 1000U);
}

TEST(PlacedScanMotion, FreeWaysOfATurnedMountEndWhereTheBeamOrTheBandEndsAsSeenFromNow) {
  std::size_t ends = 0, cut = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const DrivenSweep sweep(seed);
    for (std::size_t i = 0; i < sweep.scan.beams; ++i) {
      const double to = sweep.length(i);
      const auto way = way_in_band(sweep.mount, sweep.ray(i), sweep.band, to);
      if (!way) {
        ASSERT_EQ(sweep.placed.free_to[i], 0) << seed << ' ' << i;
        continue;
      }
      const double level = sweep.ray(i).head<2>().norm();
      ASSERT_NEAR(static_cast<double>(sweep.placed.free_to[i]), way->end * level, 1e-4 * way->end)
          << seed << ' ' << i;
      ASSERT_NEAR(static_cast<double>(sweep.placed.free_from[i]), way->begin * level, 1e-4 * way->end);
      cut += way->end < to - 1e-3 ? 1 : 0;
      if (!sweep.moves) continue;
      // Counted from where the scanner stands now.
      const Eigen::Vector3d end = sweep.place_of(i, way->end) - sweep.mount.translation();
      ASSERT_NEAR(static_cast<double>(sweep.placed.free_x[i]), end.x(), 1.5e-3) << seed << ' ' << i;
      ASSERT_NEAR(static_cast<double>(sweep.placed.free_y[i]), end.y(), 1.5e-3) << seed << ' ' << i;
      ++ends;
    }
  }
  EXPECT_GT(ends, 1000U);
  EXPECT_GT(cut, 500U) << "beams that leave the band before they end";
}

TEST(PlacedScanMotion, TheReturnThatIsAskedForCountsInWhateverOrderTheEchoesCome) {
  // One is too near and one too far to be used.
  std::vector<std::pair<float, float>> echoes = {{1, 200}, {5, 40}, {7, 90}, {9, 10}, {20, 200}};
  do {
    PlanarScan scan;
    scan.reset(1, echoes.size(), true);
    scan.set_angles(0.5F, 0.01F);
    scan.range_max = 30;
    for (std::size_t i = 0; i < echoes.size(); ++i) {
      scan.set_hit(scan.index(0, i), echoes[i].first);
      scan.intensities[scan.index(0, i)] = echoes[i].second;
    }
    const auto expect = [&](EchoChoice choice, float range, float intensity, float free_to) {
      SourceSettings settings;
      settings.echoes = choice;
      settings.range_min = 2;
      settings.range_max = 18;
      BeamRays rays;
      rays.build(scan, Pose::Identity(), {}, {});
      PlacedScan sweep;
      condition(scan, rays, settings, sweep);
      EXPECT_EQ(sweep.kind[0], Return::surface);
      EXPECT_EQ(sweep.range[0], range);
      EXPECT_EQ(sweep.intensity[0], intensity);
      EXPECT_NEAR(sweep.free_to[0], free_to, 1e-5);
      return sweep.early_echoes;
    };
    EXPECT_TRUE(expect(EchoChoice::first, 5, 40, 5).empty());
    EXPECT_TRUE(expect(EchoChoice::last, 9, 10, 9).empty());
    EXPECT_TRUE(expect(EchoChoice::strongest, 7, 90, 7).empty());
    // What the first one hides is seen through it, but not known to be free.
    auto early = expect(EchoChoice::all, 9, 10, 5);
    ASSERT_EQ(early.size(), 2U);
    std::sort(early.begin(), early.end(), [](const auto& a, const auto& b) { return a.x < b.x; });
    EXPECT_NEAR(early[0].x, 5 * std::cos(0.5), 1e-5);
    EXPECT_NEAR(early[1].y, 7 * std::sin(0.5), 1e-5);
    EXPECT_EQ(early[0].intensity, 40);
    EXPECT_EQ(early[1].intensity, 90);
  } while (std::next_permutation(echoes.begin(), echoes.end()));
}

TEST(PlacedScanMotion, EarlyReturnsMoveWithTheirBeam) {
  sim::Rng rng(11);
  const Drive drive(3, Pose::Identity());
  const Pose mount = random_mount(rng);
  PlanarScan scan;
  scan.reset(100, 2, true);
  scan.set_angles(-1, 0.02F);
  scan.range_max = 30;
  scan.stamp = start + span_from_seconds(1.1);
  scan.time_increment = 0.0006F;
  for (std::size_t i = 0; i < 100; ++i) {
    scan.set_hit(scan.index(i, 0), 4);
    scan.set_hit(scan.index(i, 1), 9);
    scan.intensities[scan.index(i, 0)] = static_cast<float>(i);
  }
  SourceSettings settings;
  settings.echoes = EchoChoice::all;
  BeamRays rays;
  rays.build(scan, mount, {}, {});
  SweepMotion motion;
  motion.follow(drive.moment(), times_of(scan));
  PlacedScan sweep;
  measure(scan, rays, settings, sweep);
  transform(rays, motion, settings.noise, sweep);
  ASSERT_EQ(sweep.early_echoes.size(), 100U);
  for (std::size_t i = 0; i < 100; ++i) {
    const double angle = -1 + 0.02 * static_cast<double>(i);
    const Eigen::Vector3d then = mount * Eigen::Vector3d(4 * std::cos(angle), 4 * std::sin(angle), 0);
    const Eigen::Vector3d now = drive.now(then, 1.1 + 0.0006 * static_cast<double>(i));
    EXPECT_NEAR(static_cast<double>(sweep.early_echoes[i].x), now.x(), 8e-4) << i;
    EXPECT_NEAR(static_cast<double>(sweep.early_echoes[i].y), now.y(), 8e-4) << i;
    EXPECT_EQ(sweep.early_echoes[i].intensity, static_cast<float>(i));
  }
}

TEST(PlacedScanMotion, WindowsHoldAtTheirEdges) {
  PlanarScan scan;
  scan.reset(5, 1, true);
  scan.set_angles(-0.5F, 0.25F);
  scan.range_max = 30;
  for (std::size_t i = 0; i < 5; ++i) scan.set_hit(i, 2 + static_cast<float>(i)), scan.intensities[i] = 8;
  const auto surfaces = [&](auto change) {
    SourceSettings settings;
    settings.veil_filter = false;
    change(settings);
    BeamRays rays;
    rays.build(scan, Pose::Identity(), {}, {});
    PlacedScan sweep;
    condition(scan, rays, settings, sweep);
    std::vector<int> found;
    for (std::size_t i = 0; i < 5; ++i) {
      const bool wanted = settings.wants(scan, i);
      EXPECT_EQ(sweep.kind[i] == Return::surface, wanted) << "points and surfaces are chosen alike";
      if (wanted) found.push_back(static_cast<int>(i));
    }
    return found;
  };
  using List = std::vector<int>;
  EXPECT_EQ(surfaces([](auto& s) { s.range_min = 3; }), (List{1, 2, 3, 4}));
  EXPECT_EQ(surfaces([](auto& s) { s.range_max = 5; }), (List{0, 1, 2, 3}));
  EXPECT_EQ(surfaces([](auto& s) { s.angle_min = -0.25; }), (List{1, 2, 3, 4}));
  EXPECT_EQ(surfaces([](auto& s) { s.angle_max = 0.25; }), (List{0, 1, 2, 3}));
}

TEST(PlacedScanMotion, ABeamWithoutReturnProvesNoMoreThanIsSaidOfIt) {
  PlanarScan scan;
  scan.reset(3, 1, false);
  scan.set_angles(-0.1F, 0.1F);
  scan.range_max = 30;
  scan.set_without_hit(0, BeamStatus::none);
  scan.set_without_hit(1, BeamStatus::near);
  const auto free_to = [&](double no_return_free_range) {
    SourceSettings settings;
    settings.no_return_free_range = no_return_free_range;
    BeamRays rays;
    rays.build(scan, Pose::Identity(), {}, {});
    PlacedScan sweep;
    condition(scan, rays, settings, sweep);
    EXPECT_EQ(sweep.free_to[1], 0) << "something is too near to measure";
    EXPECT_EQ(sweep.free_to[2], 0) << "not observed";
    return sweep.free_to[0];
  };
  EXPECT_EQ(free_to(std::numeric_limits<double>::infinity()), 30);
  EXPECT_EQ(free_to(12), 12);
  EXPECT_EQ(free_to(40), 30);
  EXPECT_EQ(free_to(0), 0);
  scan.free_from = {5, 5, 5};
  EXPECT_EQ(free_to(12), 12);
  EXPECT_EQ(free_to(4), 0) << "nearer than what was observed";
}

}  // namespace
}  // namespace lidard
