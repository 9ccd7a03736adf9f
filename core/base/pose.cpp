// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/pose.h"

#include <cmath>

namespace lidard {

Pose make_pose(const Eigen::Vector3d& xyz, const Eigen::Vector3d& rpy) {
  Pose pose = Pose::Identity();
  pose.translation() = xyz;
  pose.linear() = (Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) *
                   Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
                   Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX()))
                      .toRotationMatrix();
  return pose;
}

Eigen::Vector3d rpy_of(const Pose& pose) {
  const Eigen::Matrix3d& r = pose.linear();
  const double level = std::hypot(r(0, 0), r(1, 0));
  const double pitch = std::atan2(-r(2, 0), level);
  // Looking straight up or down, roll and yaw turn about one axis: all of it counts as yaw.
  if (level < 1e-7) return {0, pitch, std::atan2(-r(0, 1), r(1, 1))};
  return {std::atan2(r(2, 1), r(2, 2)), pitch, std::atan2(r(1, 0), r(0, 0))};
}

bool is_rigid(const Pose& pose) {
  constexpr double tolerance = 1e-6;
  const Eigen::Matrix3d& r = pose.linear();
  return pose.matrix().allFinite() && (r * r.transpose()).isApprox(Eigen::Matrix3d::Identity(), tolerance) &&
         r.determinant() > 0;
}

}  // namespace lidard
