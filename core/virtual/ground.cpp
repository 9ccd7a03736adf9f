// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/virtual/ground.h"

#include <cmath>

#include "core/base/bytes_set.h"

namespace lidard {
namespace {

// Between sparse rings a slope could be anything; what rises by more is no ground, m.
constexpr float most_rise = 0.3F;
// So far outward the ground must have gone on before it counts as higher, m.
constexpr float least_advance = 0.5F;

void measure(const RingGrid& grid, const Eigen::Vector3f& up, Ground& ground) {
  const std::size_t cells = grid.kind.size();
  const BeamEnd* const ends = grid.ends.data();
  const float* const range = grid.range.data();
  float* const height = ground.height.data();
  float* const distance = ground.distance.data();
  const float x = up.x(), y = up.y(), z = up.z(), sensor = ground.sensor;
  for (std::size_t i = 0; i < cells; ++i) {
    const float rise = x * ends[i].x + y * ends[i].y + z * ends[i].z;
    height[i] = rise + sensor;
    distance[i] = std::sqrt(std::max(0.0F, range[i] * range[i] - rise * rise));
  }
}

void find_slope(const RingGrid& grid, const GroundSettings& settings, Ground& ground) {
  const auto slack = static_cast<float>(settings.tolerance);
  const auto steepest = static_cast<float>(settings.steepest);
  for (std::size_t c = 0; c < grid.columns(); ++c) {
    float height = 0;
    float distance = 0;
    for (std::size_t r = 0; r < grid.rings(); ++r) {
      const std::size_t i = grid.index(c, r);
      if (grid.kind[i] != Beam::point) continue;
      const float level = ground.distance[i];
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
  resize_amply(cells, ground.is_ground, ground.height, ground.distance);
  ground.is_ground.assign(cells, 0);
  ground.sensor = static_cast<float>(vehicle_from_cloud.translation().z() - settings.z);
  measure(grid, vehicle_from_cloud.linear().row(2).transpose().cast<float>(), ground);
  if (!ground.known) return;
  if (settings.model == GroundModel::slope) {
    find_slope(grid, settings, ground);
    return;
  }
  const auto limit = static_cast<float>(settings.tolerance);
  const float* const height = ground.height.data();
  const Beam* const kind = grid.kind.data();
  char* const is_ground = ground.is_ground.data();
  for (std::size_t i = 0; i < cells; ++i)
    is_ground[i] = static_cast<char>((height[i] <= limit ? 1 : 0) & (kind[i] == Beam::point ? 1 : 0));
}

}  // namespace lidard
