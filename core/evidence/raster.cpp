// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/evidence/raster.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/angle.h"
#include "core/base/clones.h"

namespace lidard {
namespace {

// m; a nearer point has no direction.
constexpr float nearest = 0.001F;

// m; a segment that extends less across a beam lies along it.
constexpr float narrowest = 2e-4F;

float beams_to(float x, float y, float first, float per_rad, float turn) {
  float at = (fast_atan2(y, x) - first) * per_rad;
  at = at < 0 ? at + turn : at;
  at = at < 0 ? at + turn : at;
  return at >= turn ? at - turn : at;
}

/// Positions are small enough for this conversion, which costs one instruction.
std::size_t index_of(float at) { return static_cast<std::size_t>(static_cast<std::int32_t>(at)); }

/// A step between two positions, in beams, along the shorter arc.
float short_way(float span, float turn) {
  if (span > turn / 2) return span - turn;
  return span < -turn / 2 ? span + turn : span;
}

void keep_nearer(RangeLayer& layer, std::size_t beam, float range, float intensity) {
  if (!(range < layer.range[beam])) return;
  layer.range[beam] = range;
  layer.intensity[beam] = intensity;
}

Raster::Point point_of(const PlacedScan& sweep, std::size_t i) {
  return {sweep.x[i], sweep.y[i], sweep.intensity.empty() ? 0.0F : sweep.intensity[i]};
}

}  // namespace

void RangeLayer::clear(std::size_t beams) {
  range.assign(beams, std::numeric_limits<float>::infinity());
  intensity.assign(beams, 0);
}

Raster::Raster(const ScanGrid& grid)
    : grid_(grid),
      turn_(static_cast<float>(two_pi / grid.increment)),
      per_rad_(static_cast<float>(1 / grid.increment)),
      first_(static_cast<float>(grid.angle_min)) {
  for (std::size_t i = 0; i < grid.beams; ++i) {
    cosine_.push_back(static_cast<float>(std::cos(grid.angle(i))));
    sine_.push_back(static_cast<float>(std::sin(grid.angle(i))));
  }
}

float Raster::position(float x, float y) const { return beams_to(x, y, first_, per_rad_, turn_); }

LIDARD_CLONES void Raster::positions(const float* x, const float* y, std::size_t count, float* at) const {
  const float first = first_, per_rad = per_rad_, turn = turn_;
  for (std::size_t i = 0; i < count; ++i) at[i] = beams_to(x[i], y[i], first, per_rad, turn);
}

void Raster::draw(const PlacedScan& sweep, RangeLayer& layer) {
  const std::size_t n = sweep.kind.size();
  positions_.resize(n);
  positions(sweep.x.data(), sweep.y.data(), n, positions_.data());
  bool linked_before = false;
  Point next = n > 0 ? point_of(sweep, 0) : Point{};
  auto corner = sweep.corners.begin();
  for (std::size_t i = 0; i < n; ++i) {
    const Point p = next;
    if (i + 1 < n) next = point_of(sweep, i + 1);
    if (sweep.kind[i] != Return::surface) {
      linked_before = false;
      continue;
    }
    const bool linked = sweep.linked[i] != 0;
    if (corner != sweep.corners.end() && corner->beam == i) {
      draw_segment(p, corner->at, layer);
      draw_segment(corner->at, next, layer);
      ++corner;
    } else if (linked) {
      draw_segment(p, next, positions_[i], positions_[i + 1], layer);
    }
    if (!linked && !linked_before) draw_point(p, positions_[i], layer);
    if (linked != linked_before) draw_end(p, linked ? next : point_of(sweep, i - 1), positions_[i], layer);
    linked_before = linked;
  }
  for (const Point& echo : sweep.early_echoes) draw_point(echo, layer);
}

void Raster::draw_mixed_pixels(const PlacedScan& sweep, RangeLayer& layer) const {
  for (std::size_t i = 0; i < sweep.kind.size(); ++i) {
    if (sweep.kind[i] == Return::mixed_pixel) draw_point(point_of(sweep, i), layer);
  }
}

void Raster::draw_point(Point p, RangeLayer& layer) const { draw_point(p, position(p.x, p.y), layer); }

void Raster::draw_segment(const Point& p, const Point& q, RangeLayer& layer) const {
  draw_segment(p, q, position(p.x, p.y), position(q.x, q.y), layer);
}

std::size_t Raster::nearest_beam(float at) const {
  const std::size_t beam = index_of(at + 0.5F);
  // The half beam before the first one belongs to it.
  return beam >= grid_.beams && at >= turn_ - 0.5F ? 0 : beam;
}

void Raster::draw_point(Point p, float at, RangeLayer& layer) const {
  const float range = std::sqrt(p.x * p.x + p.y * p.y);
  const std::size_t beam = nearest_beam(at);
  if (range >= nearest && beam < grid_.beams) keep_nearer(layer, beam, range, p.intensity);
}

void Raster::draw_end(Point p, Point inner, float at, RangeLayer& layer) const {
  const float range = std::sqrt(p.x * p.x + p.y * p.y);
  const std::size_t beam = nearest_beam(at);
  if (range < nearest || beam >= grid_.beams) return;
  const float dx = p.x - inner.x;
  const float dy = p.y - inner.y;
  // The surface is extended to the middle of the beam, unless it is slanted too much.
  const float across = cosine_[beam] * dy - sine_[beam] * dx;
  const float drawn_out = std::fabs(across) > 1e-6F ? (p.x * dy - p.y * dx) / across : range;
  const bool fits = std::fabs(drawn_out - range) * per_rad_ <= range / 2;
  keep_nearer(layer, beam, fits ? drawn_out : range, p.intensity);
}

void Raster::draw_segment(const Point& p, const Point& q, float at_p, float at_q, RangeLayer& layer) const {
  const float span = short_way(at_q - at_p, turn_);
  const float from = span < 0 ? at_q : at_p;
  const float to = from + std::fabs(span);
  // Rounded up, without a call of the mathematical library.
  const auto below = static_cast<std::int32_t>(from);
  const std::int32_t first = below + (static_cast<float>(below) < from ? 1 : 0);
  fill(p, q, static_cast<std::size_t>(first), to, layer);
  if (to >= turn_) fill(p, q, 0, to - turn_, layer);
}

inline void Raster::fill(const Point& p, const Point& q, std::size_t first, float to,
                         RangeLayer& layer) const {
  const std::size_t last = std::min(grid_.beams, index_of(to) + 1);
  for (std::size_t beam = first; beam < last; ++beam) {
    const float c = cosine_[beam];
    const float s = sine_[beam];
    const float side_p = c * p.y - s * p.x;
    const float side_q = c * q.y - s * q.x;
    const float both = side_p - side_q;
    const float ahead_p = c * p.x + s * p.y;
    const float ahead_q = c * q.x + s * q.y;
    // If a surface lies along the beam, its nearer end counts.
    const float along = ahead_p < ahead_q ? 0.0F : 1.0F;
    const float share = std::fabs(both) < narrowest ? along : std::clamp(side_p / both, 0.0F, 1.0F);
    const float range = ahead_p + share * (ahead_q - ahead_p);
    if (range > nearest) keep_nearer(layer, beam, range, p.intensity + share * (q.intensity - p.intensity));
  }
}

}  // namespace lidard
