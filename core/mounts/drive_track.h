// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "core/mounts/planar_pose.h"

namespace lidard {

/// A pose of the vehicle in the plane, as odometry has it.
struct OdometryPose {
  double time = 0;  ///< s since the beginning of the drive
  PlanarPose pose;
};

/// Where the vehicle was by its odometry, with distances and angles multiplied by two scales; between two
/// poses both change at a steady rate.
class DriveTrack {
 public:
  /// `poses` by time, at least two.
  explicit DriveTrack(std::vector<OdometryPose> poses, double scale = 1, double turn_scale = 1);
  bool covers(double time) const { return time >= poses_.front().time && time <= poses_.back().time; }
  PlanarPose at(double time) const;
  /// m driven up to a time; a turn of 1 rad counts as half a metre.
  double way(double time) const;
  /// True if the vehicle stands from `reach` s before to `reach` s after a time.
  bool stands(double time, double reach) const {
    return covers(time - reach) && covers(time + reach) && way(time + reach) - way(time - reach) < 0.002;
  }

 private:
  std::size_t after(double time) const;
  std::vector<OdometryPose> poses_;
  std::vector<double> ways_;
};

}  // namespace lidard
