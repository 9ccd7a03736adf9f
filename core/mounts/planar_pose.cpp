// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/mounts/planar_pose.h"

#include <cmath>

#include "core/base/angle.h"

namespace lidard {

using Eigen::Vector2d;

Vector2d PlanarPose::turned(const Vector2d& p) const {
  const double c = std::cos(yaw), s = std::sin(yaw);
  return {c * p.x() - s * p.y(), s * p.x() + c * p.y()};
}

PlanarPose PlanarPose::operator*(const PlanarPose& other) const {
  const Vector2d at = *this * other.position();
  return {at.x(), at.y(), std::remainder(yaw + other.yaw, two_pi)};
}

PlanarPose PlanarPose::inverse() const {
  const Vector2d back = PlanarPose{0, 0, -yaw}.turned(position());
  return {-back.x(), -back.y(), -yaw};
}

double PlanarPose::distance_to(const PlanarPose& other) const { return std::hypot(other.x - x, other.y - y); }

double PlanarPose::angle_to(const PlanarPose& other) const {
  return std::abs(std::remainder(other.yaw - yaw, two_pi));
}

}  // namespace lidard
