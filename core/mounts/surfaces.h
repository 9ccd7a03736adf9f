// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "core/mounts/still_view.h"

namespace lidard {

/// A straight upright surface as one laser sees it, from above, in the level frame of its sensor.
struct Surface {
  Eigen::Vector2d middle{0, 0};  ///< m, weighted
  Eigen::Vector2d along{1, 0};   ///< unit vector
  Eigen::Vector2d normal{0, 1};  ///< unit vector, towards the sensor
  double from = 0, to = 0;       ///< m along the surface, from `middle`
  double height = 0;             ///< m above the sensor, mean
  double var_offset = 0;         ///< m^2, of the position of `middle` across the surface
  double var_slope = 0;          ///< rad^2
  /// By how much an offset of the ranges moves the surface across (m/m) and turns it (rad/m).
  double offset_by_range = 0, slope_by_range = 0;
  std::size_t ring = 0;
  std::size_t first_beam = 0, last_beam = 0;
  std::array<Eigen::Vector2d, 12> points;  ///< some of its returns

  double length() const { return to - from; }
};

/// Appends the straight surfaces of a view.
void find_surfaces(const StillView& view, std::vector<Surface>& surfaces);
/// The surfaces of all lasers of a multi-plane lidar that are upright: another laser sees the same line
/// higher or lower.
std::vector<Surface> find_upright(const std::vector<StillView>& views);

/// The normals and positions of short lines (9 beams) of the surface, for what the surfaces determine: a
/// curve shows here.
struct LocalLine {
  Eigen::Vector2d middle, normal;
  double var_normal;  ///< rad^2, noise of the normal
};
std::vector<LocalLine> local_lines(const StillView& view, const Surface& surface);

}  // namespace lidard
