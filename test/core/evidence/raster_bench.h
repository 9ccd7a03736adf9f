// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "core/base/angle.h"
#include "core/evidence/raster.h"
#include "test/sim/world/units.h"

namespace lidard::test::raster {

using Point = Raster::Point;

constexpr float nothing = std::numeric_limits<float>::infinity();

inline ScanGrid full_circle(std::size_t beams) {
  ScanGridSpec spec;
  spec.beams = beams;
  return make_grid(spec).value();
}

inline ScanGrid span_of(double from, double to, double increment) {
  ScanGridSpec spec;
  spec.angle_min = from;
  spec.angle_max = to;
  spec.angle_increment = increment;
  return make_grid(spec).value();
}

inline const std::vector<ScanGrid>& grids() {
  static const std::vector<ScanGrid> all = {full_circle(360), full_circle(1441), span_of(-1, 1, 0.01),
                                            span_of(0.3, 5.9, 0.02), span_of(0, 2 * pi_d, 2 * degree)};
  return all;
}

inline RangeLayer empty_layer(const ScanGrid& grid) {
  RangeLayer layer;
  layer.clear(grid.beams);
  return layer;
}

inline double angle_of(const Point& p) {
  return std::atan2(static_cast<double>(p.y), static_cast<double>(p.x));
}
inline double range_of(const Point& p) {
  return std::hypot(static_cast<double>(p.x), static_cast<double>(p.y));
}

inline Point at(double range, double angle, double intensity = 0) {
  return {static_cast<float>(range * std::cos(angle)), static_cast<float>(range * std::sin(angle)),
          static_cast<float>(intensity)};
}

/// Where a ray from the origin meets the segment from p to q: m, and the share of the way from p.
struct Meeting {
  double range, share;
};
inline std::optional<Meeting> meet(double angle, const Point& p, const Point& q) {
  const double c = std::cos(angle), s = std::sin(angle);
  const double px = static_cast<double>(p.x), py = static_cast<double>(p.y);
  const double dx = static_cast<double>(q.x) - px, dy = static_cast<double>(q.y) - py;
  const double slope = c * dy - s * dx;
  if (std::abs(slope) < 1e-9) return std::nullopt;
  const double share = (s * px - c * py) / slope;
  const double range = (px * dy - py * dx) / slope;
  if (share < 0 || share > 1 || range <= 0) return std::nullopt;
  return Meeting{range, share};
}

}  // namespace lidard::test::raster
