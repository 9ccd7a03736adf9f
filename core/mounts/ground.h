// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/base/angle.h"
#include "core/base/pose.h"

namespace lidard {

/// The ground on which the vehicle stands, in the frame of a multi-plane lidar.
struct GroundPlane {
  Eigen::Vector3d up{0, 0, 1};  ///< unit normal
  double height = 0;            ///< m, of the sensor above the ground
  std::size_t points = 0;
};

/// By how much the ground of a yard may differ from that under the wheels: a yard slopes, a tyre gives.
/// Standard deviations.
constexpr double ground_tilt_sigma = 0.3 * rad_per_deg;  // rad
constexpr double ground_height_sigma = 0.015;            // m

/// The largest plane below the sensor that lies within 25 degrees and 0.7 m of where `base_from_sensor` has
/// the plane z = 0; nothing if there is none of 200 points, or if it is not seen near and far in a third of
/// the directions that meet it.
std::optional<GroundPlane> find_ground(const std::vector<Eigen::Vector3d>& points,
                                       const Pose& base_from_sensor);

/// Turns coordinates of a sensor to its level frame, which has the same yaw: the roll and pitch of a pose.
Eigen::Matrix3d tilt_of(const Eigen::Matrix3d& rotation);
/// The same where the vertical is known.
Eigen::Matrix3d tilt_to(const Eigen::Vector3d& up);
/// rad, of the x axis seen from above.
double yaw_of(const Eigen::Matrix3d& rotation);

}  // namespace lidard
