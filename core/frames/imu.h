// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <string>

#include "core/base/time.h"

namespace lidard {

/// One sample of an inertial unit, in the axes of `frame_id`. As measured: no bias is taken off.
struct ImuSample {
  std::string frame_id;
  Stamp stamp;
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();     ///< rad/s
  Eigen::Vector3d linear_acceleration = Eigen::Vector3d::Zero();  ///< m/s²; at rest +g along what is up
  std::optional<Eigen::Quaterniond> orientation;  ///< turns these axes to those with z up; yaw from anywhere
};

}  // namespace lidard
