// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "core/mounts/placement.h"

namespace lidard {

/// A pose of the vehicle in the plane, as odometry has it.
struct OdometryPose {
  double time = 0;  ///< s since the beginning of the drive
  PlanarPose pose;
};

/// A sweep of a sensor while the vehicle drives, in the level frame of the sensor.
struct DriveSweep {
  std::size_t sensor = 0;
  double time = 0;  ///< s, of the middle of the sweep, by the sensor's stamps
  struct Return {
    Eigen::Vector2d point;  ///< m, where the sensor was when it was measured
    double later = 0;       ///< s, after `time`
  };
  std::vector<Return> returns;  ///< neighbours by azimuth
};

/// What a drive says of a sensor.
struct DriveEstimate {
  PlanarPose pose;                                       ///< in base_frame
  double time_offset = 0;                                ///< s, to be added to the sensor's stamps
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();  ///< of x, y (m), yaw (rad), time_offset (s)
  std::array<bool, 4> determined{false, false, false, false};
};

struct DriveSolution {
  std::vector<DriveEstimate> sensors;
  double scale = 1, turn_scale = 1;  ///< by which the odometry's distances and angles are to be multiplied
  std::size_t residuals = 0;
  double rms = 0;  ///< m, of the residuals
};

/// Finds where sensors stand on the vehicle from how what they see moves while it drives: surfaces of a sweep
/// against returns of sweeps 0.4 to 1.6 s later, of the same and of other sensors. `configured`: poses in
/// base_frame, up to 0.1 m and 3 degrees wrong; what the drive does not determine stays.
DriveSolution solve_drive(const std::vector<OdometryPose>& odometry, const std::vector<DriveSweep>& sweeps,
                          const std::vector<PlanarPose>& configured);

}  // namespace lidard
