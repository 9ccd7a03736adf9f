// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/virtual/ring_links.h"

#include <algorithm>
#include <cmath>

#include "core/base/bytes.h"
#include "core/base/clones.h"
#include "core/evidence/placed_scan.h"

namespace lidard {
namespace {

using namespace breakpoint;

/// Longest distance between two returns of one surface per m of range, for beams `apart` (rad).
float slope_of(double apart) {
  // The rule links no surface between widely spaced rings, so the limit is relaxed there.
  const double limit = std::max(steepest, 3 * apart);
  return static_cast<float>(std::sin(apart) / std::sin(std::min(limit, pi_d / 2) - apart));
}

}  // namespace

void RingLinks::set(const RingGrid& grid, double noise) {
  grid_ = &grid;
  slack_ = static_cast<float>(3 * noise);
  level_slope_ = slope_of(std::min(grid.step(), 0.2));
  levels_.assign(grid.kind.size(), Link::not_asked);
  upright_slopes_.assign(grid.rings(), 0);
  for (std::size_t r = 0; r + 1 < grid.rings(); ++r) {
    if (!grid.is_known(r) || !grid.is_known(r + 1)) continue;
    upright_slopes_[r] = slope_of(std::min(std::fabs(grid.elevation(r + 1) - grid.elevation(r)), 0.3));
  }
  find_lone_returns();
}

/// Marks the returns beside which a beam of their ring passes on both sides.
LIDARD_CLONES void RingLinks::mark_lone_in_ring() {
  const std::size_t cells = grid_->kind.size(), rings = grid_->rings();
  resize_amply(cells, lone_in_ring_);
  resize_amply(cells + 4 * rings, lengths_);
  const Beam* const kinds = grid_->kind.data();
  const float* const range = grid_->range.data();
  float* const lengths = lengths_.data() + 2 * rings;
  for (std::size_t i = 0; i < cells; ++i)
    lengths[i] = kinds[i] == Beam::point || kinds[i] == Beam::none ? range[i] : 0;
  std::copy_n(lengths, 2 * rings, lengths + cells);
  std::copy_n(lengths + cells - 2 * rings, 2 * rings, lengths_.data());
  std::uint8_t* const marks = lone_in_ring_.data();
  const float* const first = lengths_.data();
  for (std::size_t i = 0; i < cells; ++i) {
    const float* const at = first + i;
    const float beyond = at[2 * rings] + PlacedScan::lone_depth;
    const int before = (at[rings] > beyond ? 1 : 0) | (at[0] > beyond ? 1 : 0);
    const int after = (at[3 * rings] > beyond ? 1 : 0) | (at[4 * rings] > beyond ? 1 : 0);
    marks[i] = static_cast<std::uint8_t>(before & after & (kinds[i] == Beam::point ? 1 : 0));
  }
}

void RingLinks::find_lone_returns() {
  lone_returns_.clear();
  const std::size_t rings = grid_->rings(), columns = grid_->columns();
  if (columns <= 4) return;
  mark_lone_in_ring();
  const float* const lengths = lengths_.data() + 2 * rings;
  each_set(lone_in_ring_.data(), lone_in_ring_.size(), [&](std::size_t i) {
    const std::size_t column = i / rings, ring = i % rings;
    const float beyond = lengths[i] + PlacedScan::lone_depth;
    // Two drops may be neighbours.
    const bool below = ring == 0 || lengths[i - 1] > beyond || (ring > 1 && lengths[i - 2] > beyond);
    const bool above =
        ring + 1 >= rings || lengths[i + 1] > beyond || (ring + 2 < rings && lengths[i + 2] > beyond);
    if (!below || !above) return;
    std::size_t before = grid_->index(this->before(column), ring),
                after = grid_->index(grid_->after(column), ring);
    if (!(lengths[before] > beyond)) before = grid_->index(this->before(this->before(column)), ring);
    if (!(lengths[after] > beyond)) after = grid_->index(grid_->after(grid_->after(column)), ring);
    lone_returns_.push_back({i, lengths[before] < lengths[after] ? before : after});
  });
  // A beam that goes on farther may meet a lone return there.
  for (LoneReturn& one : lone_returns_) {
    for (const LoneReturn* beside = &one; beside != nullptr; beside = lone_return(one.shown_by))
      one.shown_by = beside->shown_by;
  }
}

const RingLinks::LoneReturn* RingLinks::lone_return(std::size_t i) const {
  const auto is_before = [](const LoneReturn& one, std::size_t beam) { return one.beam < beam; };
  const auto at = std::lower_bound(lone_returns_.begin(), lone_returns_.end(), i, is_before);
  return at != lone_returns_.end() && at->beam == i ? &*at : nullptr;
}

bool RingLinks::in_line(std::size_t a, std::size_t b, std::size_t c) const {
  const Eigen::Vector3f line = end(c) - end(a);
  const Eigen::Vector3f middle = end(b) - end(a);
  return line.cross(middle).norm() <= (slack_ + line_tolerance) * line.norm();
}

/// True if four returns lie on one line with steadily growing steps.
bool RingLinks::grazing(std::size_t a, std::size_t b, std::size_t c, std::size_t d) const {
  const Eigen::Vector3f line = end(d) - end(a);
  const float step = (end(c) - end(b)).norm();
  const float sides = std::max((end(b) - end(a)).norm(), (end(d) - end(c)).norm());
  if (step > longest_grazing_step || step > steady_growth * sides) return false;
  const float limit = (slack_ + line_tolerance) * line.norm();
  return line.cross(end(b) - end(a)).norm() <= limit && line.cross(end(c) - end(a)).norm() <= limit;
}

bool RingLinks::is_level(std::size_t i) const {
  const std::size_t column = i / grid_->rings(), ring = i % grid_->rings();
  const std::size_t beside = grid_->index(grid_->after(column), ring);
  return is_point(i) && is_point(beside) && (near(i, beside, level_slope_) || grazing_level(column, ring));
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

namespace {

// m; between sparse rings a higher rise is not ground, whatever its slope.
constexpr float most_rise = 0.3F;
// m; the ground must extend this far outward before its height is updated.
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
    std::size_t last = 0;
    float slope = -1;  // of the step to the last return, if it is a rise
    for (std::size_t r = 0; r < grid.rings(); ++r) {
      const std::size_t i = grid.index(c, r);
      if (grid.kind[i] != Beam::point) continue;
      const float level = ground.distance[i];
      const float rise = ground.height[i] - height;
      const float rise_allowed = std::min(steepest * std::fabs(level - distance), most_rise);
      if (std::fabs(rise) > rise_allowed + slack) continue;
      // A slope goes on; a thing that one ring alone meets does not.
      if (slope >= 0 && ground.height[i] - ground.height[last] >= slope / 2 * (level - ground.distance[last]))
        ground.is_ground[last] = Ground::sure;
      const bool rises = rise > slack;
      slope = rises ? rise / std::max(level - distance, 0.01F) : -1;
      ground.is_ground[i] = rises ? Ground::rise : Ground::sure;
      last = i;
      // Otherwise a wall would be climbed in small steps.
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
