// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/ground.h"

#include <cmath>

namespace lidard {
namespace {

// Between sparse rings a slope could be anything; what rises by more is no ground, m.
constexpr float most_rise = 0.3F;
// So far outward the ground must have gone on before it counts as higher, m.
constexpr float least_advance = 0.5F;

void find_slope(const RingGrid& grid, const GroundSettings& settings, Ground& ground) {
  const auto slack = static_cast<float>(settings.tolerance);
  const auto steepest = static_cast<float>(settings.steepest);
  for (std::size_t c = 0; c < grid.columns(); ++c) {
    float height = 0;
    float distance = 0;
    for (std::size_t r = 0; r < grid.rings(); ++r) {
      const std::size_t i = grid.index(c, r);
      if (grid.kind[i] != Beam::point) continue;
      const float rise = ground.height[i] - ground.sensor;
      const float level = std::sqrt(std::max(0.0F, grid.range[i] * grid.range[i] - rise * rise));
      const float rise_allowed = std::min(steepest * std::fabs(level - distance), most_rise);
      if (std::fabs(ground.height[i] - height) > rise_allowed + slack) continue;
      ground.is_ground[i] = 1;
      // A wall must not be climbed in small steps.
      if (level - distance < least_advance) continue;
      height = ground.height[i];
      distance = level;
    }
  }
}

}  // namespace

void find_ground(const RingGrid& grid, const GroundSettings& settings, const Pose& vehicle_from_cloud,
                 Ground& ground) {
  const std::size_t cells = grid.kind.size();
  ground.known = settings.model != GroundModel::none;
  if (ground.is_ground.capacity() < cells) {
    ground.is_ground.reserve(cells + cells / 16);
    ground.height.reserve(cells + cells / 16);
  }
  ground.is_ground.assign(cells, 0);
  ground.height.resize(cells);
  const Eigen::Vector3f up = vehicle_from_cloud.linear().row(2).transpose().cast<float>();
  ground.sensor = static_cast<float>(vehicle_from_cloud.translation().z() - settings.z);
  for (std::size_t i = 0; i < cells; ++i)
    ground.height[i] = up.x() * grid.x[i] + up.y() * grid.y[i] + up.z() * grid.z[i] + ground.sensor;
  if (!ground.known) return;
  if (settings.model == GroundModel::slope) {
    find_slope(grid, settings, ground);
    return;
  }
  const auto limit = static_cast<float>(settings.tolerance);
  for (std::size_t i = 0; i < cells; ++i)
    ground.is_ground[i] = static_cast<char>(ground.height[i] <= limit && grid.kind[i] == Beam::point);
}

}  // namespace lidard
