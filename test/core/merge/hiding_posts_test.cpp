// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Posts where a merged scan may overlook them: beside the last beam of a field, before something else, at the
// seam of a full circle, and while the vehicle drives. No beam onto them is free.
#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "core/merge/merger.h"
#include "core/motion/pose_track.h"
#include "test/sim/world/flat_world.h"
#include "test/sim/world/units.h"

namespace lidard {
namespace {

/// A world, a scanner, and what a merged scan seen from `origin` makes of it.
struct PostScene {
  /// The vehicle drives ahead with `speed`; the output is made `late` s after the sweep of 60 ms.
  void look(double speed = 0, double late = 0) {
    constexpr double sweep_s = 0.06, instant = 1;
    const double begin = instant - late - sweep_s;
    const double between = sweep_s / (scanner.field / scanner.increment);
    sim::Rng rng(1);
    PlanarScan scan;
    const auto place = [&](std::size_t beam) {
      return sim::Pose2{speed * (begin + static_cast<double>(beam) * between - instant), 0, 0};
    };
    if (speed != 0)
      scanner.measure(world, place, rng, scan);
    else
      scanner.measure(world, rng, scan);
    scan.stamp = t0 + span_from_seconds(begin);
    scan.time_increment = static_cast<float>(between);
    PoseTrack track;
    for (int i = 0; i <= 102; ++i)
      track.add(t0 + span_from_seconds(0.01 * i), make_pose({speed * (0.01 * i - instant), 0, 0}, {0, 0, 0}));
    ScanGridSpec spec;
    spec.beams = 1440;
    spec.range_max = range_max;
    MergeSettings settings;
    settings.points = false;
    settings.visibility = true;
    settings.how.noise = settings.source.noise = 0.01;
    Merger merger(*make_grid(spec), {}, 1, settings);
    const Pose output = make_pose({-origin.x(), -origin.y(), 0}, {0, 0, 0});
    ASSERT_TRUE(merger.add(0, scan, output * scanner.pose()));
    MergeMoment moment;
    moment.at = t0 + span_from_seconds(instant);
    moment.output_from_base = output;
    if (speed != 0) moment.track = &track;
    merger.merge(moment, {1}, {{Profile::strict, &strict}, {Profile::safety, &safety}}, nullptr);
  }
  /// Beams that end at the world before `limit` m, and those of them that are free in either profile.
  void count(double limit) {
    blocked = free = 0;
    for (std::size_t i = 0; i < strict.beams; ++i) {
      if (world.cast(origin, static_cast<double>(strict.angle(i))) > limit) continue;
      ++blocked;
      for (const PlanarScan* scan : {&strict, &safety}) free += scan->statuses[i] == BeamStatus::none ? 1 : 0;
    }
  }

  sim::FlatWorld world;
  sim::FlatScanner scanner;
  Eigen::Vector2d origin{0, 0};
  double range_max = 12;
  PlanarScan strict, safety;
  int blocked = 0, free = 0;
};

TEST(HidingPosts, TheStripBesideTheFirstBeamOfAVehicleThatDrovePastIsNotSeen) {
  int blocked = 0, free = 0;
  for (const double field : {180.0, 270.0}) {
    for (const double speed : {-1.0, -2.0, 2.0}) {
      for (const double y : {-1.5, -3.0, -6.0}) {
        PostScene scene;
        scene.scanner.field = field * degree;
        scene.scanner.increment = 0.5 * degree;
        const double aside = -speed * 0.1 / 2;
        scene.world.add_box({field > 200 ? aside + y : aside, y}, {0.04, 0.04}, 0);
        scene.look(speed, 0.04);
        scene.count(11);
        blocked += scene.blocked;
        free += scene.free;
      }
    }
  }
  EXPECT_GT(blocked, 50);
  EXPECT_LE(free, 4) << "grazing beams of " << blocked;
}

TEST(HidingPosts, WhatStandsBehindAPostOnTheNextBeamDoesNotFreeItsOtherHalf) {
  const std::pair<double, double> cases[] = {{0.5, 0}, {1.0, 0}, {0.5, 0.01}, {1.0, 0.01}};
  for (const auto& [increment, speed] : cases) {
    for (const double behind : {0.25, 0.4, 0.6, 1.0}) {
      for (const Eigen::Vector2d& origin :
           {Eigen::Vector2d(5, 3), Eigen::Vector2d(5, 6), Eigen::Vector2d(7, 5)}) {
        PostScene scene;
        scene.scanner.increment = increment * degree;
        scene.origin = origin;
        constexpr double away = 10, right = 0.01;
        const double apart = away * std::sin(increment * degree), left = -0.9 * apart;
        scene.world.add_box({away + 0.05, (right + left) / 2}, {0.05, (right - left) / 2}, 0);
        const double farther = (away + behind) / away * apart;
        scene.world.add_box({away + behind + 0.05, -1.2 * farther}, {0.05, 0.28 * farther}, 0);
        scene.look(speed);
        int overlooked = 0;
        for (std::size_t i = 0; i < scene.strict.beams; ++i) {
          const double angle = static_cast<double>(scene.strict.angle(i)),
                       truth = scene.world.cast(origin, angle);
          const Eigen::Vector2d hit = origin + truth * Eigen::Vector2d(std::cos(angle), std::sin(angle));
          if (truth > 11 || hit.x() > away + 0.101) continue;
          if (scene.strict.statuses[i] == BeamStatus::none || scene.safety.statuses[i] == BeamStatus::none)
            ++overlooked;
        }
        EXPECT_EQ(overlooked, 0) << increment << " deg, " << speed << " m/s, " << behind << " m behind, from "
                                 << origin.transpose();
      }
    }
  }
}

TEST(HidingPosts, TheSeamOfAFullCircleIsAsAnyOtherPlace) {
  for (const double increment : {0.25, 0.5, 1.0}) {
    for (const bool inclusive : {false, true}) {
      for (const double side : {4.0, -4.0}) {
        PostScene scene;
        scene.scanner.increment = increment * degree;
        scene.scanner.field = (360 - (inclusive ? 0 : increment)) * degree;
        scene.scanner.yaw = inclusive ? 0 : -increment / 2 * degree;
        const double apart = 10 * increment * degree;
        // From the last beam nearly to the first one, in a frame with x to the seam.
        const double from = inclusive ? 0.07 * apart : -apart - 0.01,
                     to = inclusive ? apart + 0.01 : -0.07 * apart;
        scene.world.add_box({-10.05, -(from + to) / 2}, {0.05, (to - from) / 2}, 0);
        scene.origin = {-5, -side};
        scene.range_max = 11;
        scene.look();
        scene.count(10.5);
        EXPECT_GT(scene.blocked, 0);
        EXPECT_EQ(scene.free, 0) << increment << " deg, " << (inclusive ? "inclusive" : "exclusive")
                                 << ", of " << scene.blocked;
      }
    }
  }
}

TEST(HidingPosts, PostsBesideTheWayOfAVehicleAreSeenWhole) {
  int blocked = 0, free = 0;
  for (const double increment : {0.5, 1.0}) {
    for (const double away : {6.0, 9.0}) {
      for (double azimuth = -110; azimuth <= 110; azimuth += 2.3) {
        for (const double half : {0.05, 0.08}) {
          for (const double ahead : {2.0, -2.0}) {
            PostScene scene;
            scene.scanner.increment = increment * degree;
            const double a = azimuth * degree;
            scene.world.add_box({away * std::cos(a), away * std::sin(a)}, {half, half}, 0);
            scene.origin = {ahead, 0};
            scene.look(1.5, 0.04);
            // Only where the scanner met the post at all.
            bool is_met = false;
            for (std::size_t i = 0; i < scene.safety.beams; ++i)
              is_met = is_met || scene.safety.statuses[i] == BeamStatus::hit;
            if (!is_met) continue;
            for (std::size_t i = 0; i < scene.strict.beams; ++i) {
              const double angle = static_cast<double>(scene.strict.angle(i));
              const Eigen::Vector2d across(-0.015 * std::sin(angle), 0.015 * std::cos(angle));
              if (scene.world.cast(scene.origin + across, angle) > 11.5 ||
                  scene.world.cast(scene.origin - across, angle) > 11.5)
                continue;
              ++blocked;
              free += scene.strict.statuses[i] == BeamStatus::none ? 1 : 0;
            }
          }
        }
      }
    }
  }
  EXPECT_GT(blocked, 2000);
  EXPECT_LE(free, blocked / 500) << "of " << blocked;
}

}  // namespace
}  // namespace lidard
