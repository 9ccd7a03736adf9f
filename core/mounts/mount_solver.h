// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/mounts/planar_pose.h"
#include "core/mounts/surroundings.h"

namespace lidard {

/// A sensor whose mount is to be found: what it sees and where it is configured to be, in the plane of
/// base_frame.
struct MountedSensor {
  Surroundings seen;
  PlanarPose configured;
};

/// A direction in which the surfaces do not determine a sensor: a turn about a point, or, with no `turn`, a
/// shift.
struct FreeDirection {
  Eigen::Vector2d shift{0, 0};  ///< unit vector in base_frame, where `turn` is false
  bool turn = false;
  Eigen::Vector2d about{0, 0};  ///< m, base_frame
};

enum class MountVerdict : std::uint8_t {
  reference,    ///< the pose is kept as configured
  found,        ///< along the determined directions
  uncertain,    ///< known no better than configured poses are
  ambiguous,    ///< the surfaces fit as well at another pose
  unconnected,  ///< shares no surfaces with a sensor that is connected to the reference
};

/// What the surfaces say of one sensor.
struct MountEstimate {
  MountVerdict verdict = MountVerdict::unconnected;
  PlanarPose pose;  ///< as configured where nothing was found
  /// Of x, y (m) and yaw (rad), standard deviations; of the mount against the reference.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  std::array<bool, 3> determined{false, false, false};  ///< x, y, yaw
  std::vector<FreeDirection> free;
  bool is_mirrored = false;  ///< fits upside down, and not as configured
  std::size_t surfaces = 0;  ///< shared with other sensors
  Agreement as_configured, as_found;
  double range_offset = 0;  ///< m, of a planar scanner
};

struct MountSolution {
  std::vector<MountEstimate> sensors;
  double bias = 0;        ///< m, the error of a surface in common for its beams that the residuals show
  double chi_square = 0;  ///< per degree of freedom
};

/// Finds the poses of the sensors against that of `reference` from the upright surfaces that they share.
/// Method and figures: weighted least squares with unknown walls, an offset of the ranges per laser, and a
/// bias per surface that is learned from the residuals.
MountSolution solve_mounts(const std::vector<MountedSensor>& sensors, std::size_t reference);

}  // namespace lidard
