// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/mounts/drive_track.h"
#include "core/mounts/surfaces.h"

namespace lidard {

/// A sweep of a sensor while the vehicle drives.
struct DriveSweep {
  double time = 0;  ///< s, of its stamp
  double step = 0;  ///< rad between neighbouring beams
  struct Return {
    Eigen::Vector3f point;   ///< m, in the frame of the sensor, where it was when it measured this
    float later = 0;         ///< s after `time`
    std::uint16_t ring = 0;  ///< neighbouring rings of a multi-plane lidar have neighbouring numbers
  };
  std::vector<Return> returns;  ///< those of a ring by azimuth
};

/// The upright surfaces of a sweep, as they are seen from where the sensor was at its stamp, `offset` s later
/// by the clock of `track`. `all`: the views of its rings, too.
std::vector<Surface> surfaces_of(const DriveSweep& sweep, const Eigen::Matrix3d& tilt,
                                 const PlanarPose& mount, double offset, const DriveTrack& track,
                                 std::vector<StillView>* all = nullptr);

/// One sweep of each sensor in so many seconds is used.
constexpr double keyframe_s = 0.5;

struct DrivenSensor {
  PlanarPose configured;  ///< in base_frame
  /// The sensor against which its pose is known; itself: none. Both keep their positions against each other.
  std::size_t held_by = 0;
  Eigen::Matrix3d tilt = Eigen::Matrix3d::Identity();  ///< to the level frame of the sensor
  std::vector<DriveSweep> sweeps;                      ///< by time
};

/// What a drive says of a sensor.
struct DriveEstimate {
  PlanarPose pose;         ///< in base_frame; as configured where it is not determined
  double time_offset = 0;  ///< s, to be added to the sensor's stamps; 0 where it is not determined
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();  ///< of x, y (m), yaw (rad), time_offset (s)
  std::array<bool, 4> determined{false, false, false, false};
  std::size_t moves = 0;  ///< between sweeps, that were used
};

struct DriveSolution {
  std::vector<DriveEstimate> sensors;
  double scale = 1, turn_scale = 1;  ///< by which the odometry's distances and angles are to be multiplied
  double scale_sigma = 1, turn_scale_sigma = 1;  ///< standard deviations
  double way_noise = 0;   ///< m, standard deviation of the odometry's position after 1 m, by the residuals
  double turn_noise = 0;  ///< rad, of its heading
};

/// Finds where sensors stand on the vehicle, and how late their stamps are against those of the odometry: the
/// motion of each sensor between two sweeps, from the upright surfaces that both show, must be that of the
/// vehicle as seen from its mount. Errors of the odometry are unknown scales and a random walk, whose size
/// the residuals show. `configured` may be wrong by 0.5 m and 20 degrees.
DriveSolution solve_drive(const std::vector<OdometryPose>& odometry,
                          const std::vector<DrivenSensor>& sensors);

}  // namespace lidard
