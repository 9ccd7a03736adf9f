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

TEST(PlacedScanMotion, ReturnsAndFreeWaysOfATurnedMountAreWhereTheyWereMeasuredAsSeenFromNow) {
  std::size_t moved_returns = 0, ends = 0, cut = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    sim::Rng rng(seed);
    const Drive drive(seed,
                      make_pose({rng.within(1), rng.within(1), rng.within(0.5)}, {0, 0, rng.within(3)}));
    const Pose mount = random_mount(rng);
    const HeightBand band{-1, 2};
    PlanarScan scan = random_scan(rng);
    const bool moves = seed % 4 != 0;
    scan.stamp = start + span_from_seconds(1.1);
    scan.time_increment = 0.06F / 180;
    SourceSettings settings;
    settings.veil_filter = false;
    BeamRays rays;
    rays.build(scan, mount, {}, band);
    SweepMotion motion;
    if (moves) {
      ASSERT_NE(motion.follow(drive.moment(), times_of(scan)), PoseOrigin::missing);
    }
    PlacedScan sweep;
    measure(scan, rays, settings, sweep);
    place(rays, motion, settings.noise, sweep);
    ASSERT_EQ(sweep.moved, moves);
    for (std::size_t i = 0; i < scan.beams; ++i) {
      const auto angle = static_cast<double>(scan.angle_min) +
                         static_cast<double>(i) * static_cast<double>(scan.angle_increment);
      const Eigen::Vector3d ray = mount.linear() * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
      const double time = 1.1 + 0.06 / 180 * static_cast<double>(i);
      const auto place_of = [&](double range) {
        const Eigen::Vector3d then = mount.translation() + range * ray;
        return moves ? drive.now(then, time) : then;
      };
      const bool hit = scan.statuses[i] == BeamStatus::hit;
      const bool none = scan.statuses[i] == BeamStatus::none;
      const double to = hit ? static_cast<double>(scan.ranges[i]) : 30;
      const auto way = way_in_band(mount, ray, band, to);
      const double height = mount.translation().z() + to * ray.z();
      const bool counts = hit && height >= band.min && height <= band.max;
      if (std::abs(height - band.min) < 1e-4 || std::abs(height - band.max) < 1e-4) continue;
      ASSERT_EQ(sweep.kind[i] == Return::surface, counts) << seed << ' ' << i;
      if (counts) {
        const Eigen::Vector3d at = place_of(to);
        ASSERT_NEAR(static_cast<double>(sweep.x[i]), at.x(), 8e-4) << seed << ' ' << i;
        ASSERT_NEAR(static_cast<double>(sweep.y[i]), at.y(), 8e-4) << seed << ' ' << i;
        moved_returns += moves ? 1 : 0;
      }
      if (!(hit || none) || !way) {
        ASSERT_EQ(sweep.free_to[i], 0) << seed << ' ' << i;
        continue;
      }
      const double level = ray.head<2>().norm();
      ASSERT_NEAR(static_cast<double>(sweep.free_to[i]), way->end * level, 1e-4 * way->end)
          << seed << ' ' << i;
      ASSERT_NEAR(static_cast<double>(sweep.free_from[i]), way->begin * level, 1e-4 * way->end);
      cut += way->end < to - 1e-3 ? 1 : 0;
      if (!moves) continue;
      // Counted from where the scanner stands now.
      const Eigen::Vector3d end = place_of(way->end) - mount.translation();
      ASSERT_NEAR(static_cast<double>(sweep.free_x[i]), end.x(), 1.5e-3) << seed << ' ' << i;
      ASSERT_NEAR(static_cast<double>(sweep.free_y[i]), end.y(), 1.5e-3) << seed << ' ' << i;
      ++ends;
    }
  }
  EXPECT_GT(moved_returns, 1000U);
  EXPECT_GT(ends, 1000U);
  EXPECT_GT(cut, 500U) << "beams that leave the band before they end";
}

std::size_t index_of(const PlanarScan& scan, std::size_t beam, float range) {
  for (std::size_t echo = 0; echo < scan.echoes; ++echo) {
    if (scan.ranges[scan.index(beam, echo)] == range) return scan.index(beam, echo);
  }
  return scan.index(beam);
}

TEST(PlacedScanMotion, TheReturnThatIsAskedForCountsInWhateverOrderTheEchoesCome) {
  sim::Rng rng(9);
  std::size_t early = 0;
  for (int round = 0; round < 20; ++round) {
    PlanarScan scan = random_scan(rng, 3);
    for (const EchoChoice choice :
         {EchoChoice::first, EchoChoice::last, EchoChoice::strongest, EchoChoice::all}) {
      SourceSettings settings;
      settings.veil_filter = false;
      settings.echoes = choice;
      settings.intensity_min = 20;
      settings.intensity_max = 180;
      settings.range_min = 2;
      settings.range_max = 18;
      BeamRays rays;
      rays.build(scan, Pose::Identity(), {}, {});
      PlacedScan sweep;
      condition(scan, rays, settings, sweep);
      std::size_t next_early = 0;
      for (std::size_t beam = 0; beam < scan.beams; ++beam) {
        std::vector<std::size_t> usable;
        for (std::size_t echo = 0; echo < 3; ++echo) {
          const std::size_t i = scan.index(beam, echo);
          if (scan.statuses[i] == BeamStatus::hit && scan.ranges[i] >= 2 && scan.ranges[i] <= 18 &&
              scan.intensities[i] >= 20 && scan.intensities[i] <= 180)
            usable.push_back(i);
        }
        ASSERT_EQ(sweep.kind[beam] == Return::surface, !usable.empty()) << beam;
        if (usable.empty()) continue;
        const auto by_range = [&](std::size_t a, std::size_t b) { return scan.ranges[a] < scan.ranges[b]; };
        const auto by_intensity = [&](std::size_t a, std::size_t b) {
          return scan.intensities[a] < scan.intensities[b];
        };
        std::sort(usable.begin(), usable.end(), by_range);
        std::size_t chosen = choice == EchoChoice::first ? usable.front() : usable.back();
        if (choice == EchoChoice::strongest) {
          chosen = *std::max_element(usable.begin(), usable.end(), by_intensity);
          // Of two that are equally strong either may count.
          if (scan.intensities[chosen] == sweep.intensity[beam])
            chosen = index_of(scan, beam, sweep.range[beam]);
        }
        ASSERT_EQ(sweep.range[beam], scan.ranges[chosen]) << beam;
        ASSERT_EQ(sweep.intensity[beam], scan.intensities[chosen]) << beam;
        const float free_to = choice == EchoChoice::all ? scan.ranges[usable.front()] : scan.ranges[chosen];
        ASSERT_NEAR(sweep.free_to[beam], free_to, 1e-5) << beam;
        if (choice != EchoChoice::all) continue;
        usable.pop_back();
        for (std::size_t k = 0; k < usable.size(); ++k, ++next_early, ++early) {
          ASSERT_LT(next_early, sweep.early_echoes.size());
          const PlacedScan::Point& p = sweep.early_echoes[next_early];
          const double angle = static_cast<double>(scan.angle(beam));
          ASSERT_NEAR(std::remainder(std::atan2(static_cast<double>(p.y), static_cast<double>(p.x)) - angle,
                                     2 * pi_d),
                      0, 1e-5);
          const auto found = std::find_if(usable.begin(), usable.end(), [&](std::size_t i) {
            return std::abs(std::hypot(p.x, p.y) - scan.ranges[i]) < 1e-4F &&
                   p.intensity == scan.intensities[i];
          });
          ASSERT_NE(found, usable.end()) << beam;
        }
      }
      if (choice == EchoChoice::all) {
        EXPECT_EQ(next_early, sweep.early_echoes.size());
      }
    }
  }
  EXPECT_GT(early, 1000U);
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
  place(rays, motion, settings.noise, sweep);
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
