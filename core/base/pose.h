// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

namespace lidard {

/// A rigid transform. `a_from_b` maps coordinates of frame b to frame a, and is the pose of b in a.
using Pose = Eigen::Isometry3d;

/// Pose from a translation (m) and fixed-axis roll, pitch, yaw (rad), the order of REP 103.
Pose make_pose(const Eigen::Vector3d& xyz, const Eigen::Vector3d& rpy);

/// True if all numbers are finite and the rotation is orthonormal and right-handed within 1e-6.
bool is_rigid(const Pose& pose);

}  // namespace lidard
