// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/base/angle.h"
#include "core/base/pose.h"
#include "test/sim/world/units.h"

namespace lidard::sim {

using lidard::rad_per_deg;

/// A place on the ground: m and rad, yaw counter-clockwise from x.
struct Pose2 {
  double x = 0;
  double y = 0;
  double yaw = 0;
};

/// The same place as a rigid transform (z = 0).
Pose to_pose(const Pose2& place);

/// Driving with constant speed and yaw rate for a while: an arc, or a straight line.
struct Twist {
  double duration = 0;  ///< s
  double speed = 0;     ///< m/s along the vehicle's x
  double yaw_rate = 0;  ///< rad/s
};

/// The place reached from `from` after `time` seconds of `twist`, in closed form.
Pose2 drive(const Pose2& from, const Twist& twist, double time);

/// Where a vehicle is at any time. Before the first twist it stands at the start, after the last one at the
/// end.
class Trajectory {
 public:
  Trajectory() = default;
  Trajectory(const Pose2& start, const std::vector<Twist>& twists);
  /// `time`: s after the start of the scene.
  Pose2 at(double time) const;
  /// Speed (m/s) at that time, 0 before the start and after the end.
  double speed(double time) const;

 private:
  struct Leg {
    double begin;
    Pose2 from;
    Twist twist;
  };
  const Leg* leg_at(double time) const;
  std::vector<Leg> legs_;
  Pose2 start_;
};

/// A place that something passes at a time; between two of them it moves on a straight line at constant
/// speed.
struct Waypoint {
  double time = 0;  ///< s after the start of the scene
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  double yaw = 0;  ///< rad; not wrapped, so that a turn of several circles can be said
};

/// Position and yaw of something that moves through `waypoints` (ascending times, at least one); it stands
/// still before the first and after the last.
Waypoint interpolate(const std::vector<Waypoint>& waypoints, double time);

}  // namespace lidard::sim
