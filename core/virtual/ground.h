// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/virtual/ring_grid.h"

namespace lidard {

/// How the ground is told from what stands on it. `plane`: returns not higher than `tolerance` above z.
/// `slope`: returns that a drive outward from the sensor's foot reaches on no steeper way than `steepest`.
enum class GroundModel : std::uint8_t { none, plane, slope };

struct GroundSettings {
  GroundModel model = GroundModel::none;
  double z = 0;            ///< m, in the vehicle's frame; with `slope`: beneath the sensor
  double tolerance = 0.1;  ///< m
  double steepest = 0.15;  ///< rise per m; with `slope`
};

/// The ground of one cloud, shared by all frames that are cut from it.
struct Ground {
  bool known = false;
  std::vector<char> is_ground;  ///< by RingGrid::index()
  std::vector<float> height;    ///< m above z
  std::vector<float> distance;  ///< m from the sensor, level
  float sensor = 0;             ///< m, the sensor's height above z
};

/// Tells the ground in `grid`; `vehicle_from_cloud` places it.
void find_ground(const RingGrid& grid, const GroundSettings& settings, const Pose& vehicle_from_cloud,
                 Ground& ground);

}  // namespace lidard
