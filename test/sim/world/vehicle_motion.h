// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/motion/pose_track.h"
#include "test/sim/world/motion.h"
#include "test/sim/world/rng.h"

namespace lidard::sim {

/// A vehicle that never stops accelerating and turning: speed 0.8 ... 2.2 m/s and yaw rate -1.2 ... 1.2 rad/s
/// swing as sines of random phase. Heading in closed form, place integrated in steps of 0.1 ms (error below a
/// nanometre per step), so that it is truth for what is interpolated.
class SwingingVehicle {
 public:
  /// `duration`: s. The swings take 1.25 ... 2.5 s.
  SwingingVehicle(std::uint64_t seed, double duration);

  /// The place `time` s after the start.
  Pose2 at(double time) const;
  double speed(double time) const { return 1.5 + 0.7 * std::sin(speed_rate_ * time + speed_phase_); }
  double yaw_rate(double time) const { return 1.2 * std::sin(turn_rate_ * time + turn_phase_); }
  /// What odometry of `rate` Hz reports between two times; stamps count from `start`.
  void report(PoseTrack& track, Stamp start, double rate, double from, double to) const;

 private:
  double yaw(double time) const {
    return 1.2 / turn_rate_ * (std::cos(turn_phase_) - std::cos(turn_rate_ * time + turn_phase_));
  }
  /// The way from `place` in `step` s, by Simpson's rule.
  Eigen::Vector2d way(double time, double step) const;

  double speed_rate_, speed_phase_, turn_rate_, turn_phase_;
  std::vector<Eigen::Vector2d> places_;  // every 0.1 ms
};

}  // namespace lidard::sim
