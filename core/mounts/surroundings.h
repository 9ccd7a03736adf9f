// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/mounts/planar_pose.h"
#include "core/mounts/surfaces.h"

namespace lidard {

/// What a sensor sees around it, for matching.
struct Surroundings {
  std::vector<StillView> views;  ///< one of a planar scanner, one per ring of a multi-plane lidar
  std::vector<Surface> surfaces;
  double height = 0;  ///< m, of the sensor
  bool is_planar() const { return views.size() == 1; }
};

/// The same as a planar scanner sees it that hangs upside down.
Surroundings mirrored(Surroundings seen);

/// How the returns of both sensors fit each other: a return is confirmed where the other sensor has one at
/// the same position, and refuted where the other sensor sees farther.
struct Agreement {
  std::size_t confirmed = 0, refuted = 0;
  std::size_t judged() const { return confirmed + refuted; }
  double share() const {
    return judged() == 0 ? 0 : static_cast<double>(confirmed) / static_cast<double>(judged());
  }
};
/// The agreement of `b` with `a` if `a_from_b` is right; nothing is judged between two multi-plane lidars.
Agreement agreement(const Surroundings& a, const Surroundings& b, const PlanarPose& a_from_b);

}  // namespace lidard
