// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "core/merge/merger.h"
#include "core/motion/pose_track.h"
#include "test/sim/world/circle.h"
#include "test/sim/world/flat_world.h"
#include "test/sim/world/units.h"

namespace lidard::test {

/// A world, scanners of a vehicle, and what a merged scan seen from `origin` makes of them.
struct MergedScene {
  MergedScene() { settings.points = false, settings.visibility = true, noise(0.01); }
  /// m that the merge and the sources are told of; the scanners' own noise is theirs.
  void noise(double deviation) { settings.how.noise = settings.source.noise = deviation; }
  void add_scanner(const Eigen::Vector2d& at, double yaw_deg, double increment_deg = 0.5) {
    sim::FlatScanner scanner;
    scanner.at = at;
    scanner.yaw = yaw_deg * degree;
    scanner.increment = increment_deg * degree;
    scanners.push_back(scanner);
  }
  /// The vehicle drives ahead with `speed`; the output is made `late` s after the sweep.
  void look(double speed = 0, double late = 0) { look(sim::Pose2{speed, 0, 0}, late); }
  /// `speed`: per s, of the vehicle's pose, which is the world's frame at the output's instant.
  void look(const sim::Pose2& speed, double late) {
    constexpr double instant = 1;
    const double begin = instant - late - sweep_s;
    const bool moves = speed.x != 0 || speed.y != 0 || speed.yaw != 0;
    const auto pose = [&](double after) {
      const double t = after - instant;
      return sim::Pose2{speed.x * t, speed.y * t, speed.yaw * t};
    };
    merger = std::make_unique<Merger>(full_circle(beams, range_max), HeightBand{}, scanners.size(), settings);
    const Pose output = make_pose({-origin.x(), -origin.y(), 0}, {0, 0, 0});
    merger->set_footprint(Footprint(outline).transformed(output));
    sim::Rng rng(1);
    for (std::size_t s = 0; s < scanners.size(); ++s) {
      const double between = sweep_s / (scanners[s].field / scanners[s].increment);
      PlanarScan scan;
      const auto place = [&](std::size_t beam) { return pose(begin + static_cast<double>(beam) * between); };
      if (moves)
        scanners[s].measure(world, place, rng, scan);
      else
        scanners[s].measure(world, rng, scan);
      for (std::size_t i = 0; i < scan.beams; ++i)
        if (rng.uniform() < invalid) scan.set_without_hit(i, BeamStatus::invalid);
      scan.stamp = t0 + span_from_seconds(begin);
      scan.time_increment = static_cast<float>(between);
      ASSERT_TRUE(merger->add(s, scan, output * scanners[s].pose()));
    }
    PoseTrack track;
    for (int i = 0; i <= 102; ++i) {
      const sim::Pose2 at = pose(0.01 * i);
      track.add(t0 + span_from_seconds(0.01 * i), make_pose({at.x, at.y, 0}, {0, 0, at.yaw}));
    }
    MergeMoment moment;
    moment.at = t0 + span_from_seconds(instant);
    moment.output_from_base = output;
    if (moves) moment.track = &track;
    merger->merge(moment, std::vector<char>(scanners.size(), 1),
                  {{Profile::strict, &strict}, {Profile::safety, &safety}}, nullptr);
  }
  /// Beams that end at the world before `limit` m, and more than `edge` m beside its edges; and those of them
  /// that are free in either profile.
  void count(double limit, double edge = 0) {
    blocked = free = 0;
    for (std::size_t i = 0; i < strict.beams; ++i) {
      const auto angle = static_cast<double>(strict.angle(i));
      const double truth = world.cast(origin, angle), aside = edge / truth;
      if (truth > limit || world.cast(origin, angle - aside) > limit ||
          world.cast(origin, angle + aside) > limit)
        continue;
      ++blocked;
      for (const PlanarScan* scan : {&strict, &safety}) free += scan->statuses[i] == BeamStatus::none ? 1 : 0;
    }
  }
  /// Checks the strict scan's beams between two angles, deg counter-clockwise.
  void expect(double from, double to, BeamStatus status) const {
    int beams_between = 0;
    for (std::size_t i = 0; i < strict.beams; ++i) {
      const double angle = static_cast<double>(strict.angle(i)) / degree;
      if (angle < from || angle > to) continue;
      ++beams_between;
      EXPECT_EQ(strict.statuses[i], status) << angle << " deg";
    }
    EXPECT_GT(beams_between, 0) << from << " to " << to;
  }
  /// Each hit is on the world, in its direction or that of half a beam beside.
  void expect_hits_on_the_world(double tolerance) const {
    const sim::FlatWorld& truth = foreign ? *foreign : world;
    for (std::size_t i = 0; i < strict.beams; ++i) {
      if (strict.statuses[i] != BeamStatus::hit) continue;
      double best = infinite;
      for (const double side : {0.0, -0.5, 0.5}) {
        const double angle =
            static_cast<double>(strict.angle(i)) + side * two_pi / static_cast<double>(beams);
        best = std::min(best, std::abs(truth.cast(origin, angle) - static_cast<double>(strict.ranges[i])));
      }
      EXPECT_LT(best, tolerance) << static_cast<double>(strict.angle(i)) / degree << " deg";
    }
  }

  sim::FlatWorld world;
  std::optional<sim::FlatWorld> foreign;  ///< the world without the vehicle's own parts
  std::vector<sim::FlatScanner> scanners;
  std::vector<Eigen::Vector2d> outline;
  Eigen::Vector2d origin{0, 0};
  std::size_t beams = 1440;
  double range_max = 12;
  double sweep_s = 0.06;
  double invalid = 0;  // share of the beams
  MergeSettings settings;
  std::unique_ptr<Merger> merger;
  PlanarScan strict, safety;
  int blocked = 0, free = 0;
};

}  // namespace lidard::test
