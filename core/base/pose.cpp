// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/pose.h"

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

bool is_rigid(const Pose& pose) {
  constexpr double tolerance = 1e-6;
  const Eigen::Matrix3d& r = pose.linear();
  return pose.matrix().allFinite() && (r * r.transpose()).isApprox(Eigen::Matrix3d::Identity(), tolerance) &&
         r.determinant() > 0;
}

}  // namespace lidard
