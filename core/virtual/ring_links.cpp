// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/virtual/ring_links.h"

#include <algorithm>
#include <cmath>

#include "core/evidence/continuity.h"

namespace lidard {
namespace {

using namespace breakpoint;

/// Longest distance between two returns of one surface per m of range, for beams `apart` (rad).
float slope_of(double apart) {
  // Between widely spaced rings no surface could ever be told by the rule; there it may be less steep.
  const double limit = std::max(steepest, 3 * apart);
  return static_cast<float>(std::sin(apart) / std::sin(std::min(limit, pi_d / 2) - apart));
}

}  // namespace

void RingLinks::set(const RingGrid& grid, double noise) {
  grid_ = &grid;
  slack_ = static_cast<float>(3 * noise);
  level_slope_ = slope_of(std::min(grid.step(), 0.2));
  upright_slopes_.assign(grid.rings(), 0);
  for (std::size_t r = 0; r + 1 < grid.rings(); ++r) {
    if (!grid.is_known(r) || !grid.is_known(r + 1)) continue;
    upright_slopes_[r] = slope_of(std::clamp(grid.elevation(r + 1) - grid.elevation(r), 0.0, 0.3));
  }
}

bool RingLinks::in_line(std::size_t a, std::size_t b, std::size_t c) const {
  const Eigen::Vector3f line = end(c) - end(a);
  const Eigen::Vector3f middle = end(b) - end(a);
  return line.cross(middle).norm() <= (slack_ + line_tolerance) * line.norm();
}

/// Four returns on one line whose steps grow steadily.
bool RingLinks::grazing(std::size_t a, std::size_t b, std::size_t c, std::size_t d) const {
  const Eigen::Vector3f line = end(d) - end(a);
  const float step = (end(c) - end(b)).norm();
  const float sides = std::max((end(b) - end(a)).norm(), (end(d) - end(c)).norm());
  if (step > longest_grazing_step || step > steady_growth * sides) return false;
  const float limit = (slack_ + line_tolerance) * line.norm();
  return line.cross(end(b) - end(a)).norm() <= limit && line.cross(end(c) - end(a)).norm() <= limit;
}

bool RingLinks::grazing_level(std::size_t column, std::size_t ring) const {
  const std::size_t next = grid_->after(column);
  const std::size_t outer_a = grid_->index(before(column), ring);
  const std::size_t outer_b = grid_->index(grid_->after(next), ring);
  return is_point(outer_a) && is_point(outer_b) &&
         grazing(outer_a, grid_->index(column, ring), grid_->index(next, ring), outer_b);
}

bool RingLinks::upright(std::size_t column, std::size_t ring) const {
  const std::size_t a = grid_->index(column, ring);
  if (!is_point(a) || !is_point(a + 1)) return false;
  if (near(a, a + 1, upright_slopes_[ring])) return true;
  if (ring == 0 || ring + 2 >= grid_->rings() || !is_point(a - 1) || !is_point(a + 2)) return false;
  return grazing(a - 1, a, a + 1, a + 2);
}

}  // namespace lidard
