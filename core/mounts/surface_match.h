// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/mounts/planar_pose.h"
#include "core/mounts/surfaces.h"

namespace lidard {

/// m, the gate of a coarse match whose start is far off.
constexpr double coarsest_gate = 1.5;
/// Brings surfaces of `b` to those of `a`, from a start up to 0.5 m and 20 degrees wrong: least squares of
/// points to lines both ways with a gate that shrinks from `gate` (m) to 3 cm.
PlanarPose match_surfaces(const std::vector<Surface>& a, const std::vector<Surface>& b, PlanarPose start,
                          double gate = coarsest_gate);

/// A pose in the plane with the information that surfaces give of it.
struct MatchedPose {
  PlanarPose pose;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< of x, y (1/m^2) and yaw (1/rad^2)
  std::size_t pairs = 0;
};

/// Improves a pose that transforms surfaces of `b` to those of `a`, from a start that is right to `gate` (m):
/// each surface of `b` against the nearest of `a` that the same laser saw.
MatchedPose refine_match(const std::vector<Surface>& a, const std::vector<Surface>& b, PlanarPose a_from_b,
                         double gate = 0.12);

}  // namespace lidard
