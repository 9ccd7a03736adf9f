// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace lidard {

/// A pose in the plane: transforms points of one level frame to another.
struct PlanarPose {
  double x = 0, y = 0, yaw = 0;  ///< m, rad

  Eigen::Vector2d position() const { return {x, y}; }
  Eigen::Vector2d turned(const Eigen::Vector2d& p) const;
  Eigen::Vector2d operator*(const Eigen::Vector2d& p) const { return turned(p) + position(); }
  PlanarPose operator*(const PlanarPose& other) const;
  PlanarPose inverse() const;
  /// m between the positions.
  double distance_to(const PlanarPose& other) const;
  /// rad between the directions, 0 to pi.
  double angle_to(const PlanarPose& other) const;
};

}  // namespace lidard
