// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/mounts/surfaces.h"

namespace lidard {

/// A pose in the plane: takes points of one level frame to another.
struct PlanarPose {
  double x = 0, y = 0, yaw = 0;  ///< m, rad

  Eigen::Vector2d turned(const Eigen::Vector2d& p) const;
  Eigen::Vector2d operator*(const Eigen::Vector2d& p) const { return turned(p) + Eigen::Vector2d(x, y); }
  PlanarPose operator*(const PlanarPose& other) const;
  PlanarPose inverse() const;
};

/// What a sensor sees, for matching.
struct SeenPlace {
  std::vector<StillView> views;  ///< one of a planar scanner, one per ring of a multi-plane lidar
  std::vector<Surface> surfaces;
  double height = 0;  ///< m, of the sensor
  bool is_planar() const { return views.size() == 1; }
};

/// The same as a planar scanner sees it that hangs upside down.
SeenPlace mirrored(SeenPlace place);

/// Brings surfaces of `b` to those of `a`, from a start up to 0.5 m and 20 degrees wrong: least squares of
/// points to lines both ways with a gate that shrinks from `gate` (m) to 3 cm.
PlanarPose match_surfaces(const std::vector<Surface>& a, const std::vector<Surface>& b, PlanarPose start,
                          double gate = 1.5);

/// How the returns of both sensors fit each other: a return is confirmed where the other sensor has one at
/// the same place, and refuted where the other sensor sees farther.
struct Agreement {
  std::size_t confirmed = 0, refuted = 0;
  std::size_t judged() const { return confirmed + refuted; }
  double share() const {
    return judged() == 0 ? 0 : static_cast<double>(confirmed) / static_cast<double>(judged());
  }
};
Agreement agreement(const SeenPlace& a, const SeenPlace& b, const PlanarPose& a_from_b);

}  // namespace lidard
