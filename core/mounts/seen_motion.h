// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/mounts/drive_fit.h"

namespace lidard {

/// How the vehicle moves, as a sensor sees it.
struct SeenMotion {
  double time = 0;           ///< s, of the first sweep that shows it
  double way = 0, turn = 0;  ///< m and rad, farthest from where it stood first
  bool is_measured = false;  ///< else the surroundings have changed, without surfaces to measure by
};

/// Finds whether the vehicle moves, from sweeps (by time) of a sensor at about `mount` in base_frame, to
/// whose level frame `tilt` leads; nothing: it stands, or nothing shows that it does not. `lowest`: m, in
/// that frame, below which returns may be of the ground, which looks the same while driving.
std::optional<SeenMotion> find_motion(const std::vector<DriveSweep>& sweeps, const Eigen::Matrix3d& tilt,
                                      const PlanarPose& mount, double lowest);

}  // namespace lidard
