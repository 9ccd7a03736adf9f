// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/base/pose.h"

namespace lidard {

/// Outline of the vehicle, a simple polygon in the xy plane of some frame, m.
class Footprint {
 public:
  /// Where a ray is inside the outline, m along the ray. `in` is 0 if it begins inside.
  struct Crossing {
    double in = 0;
    double out = 0;
  };

  /// Returns so near to the outline are the vehicle's: mirrors, cables, an outline drawn a little too small.
  static constexpr double margin_m = 0.05;

  Footprint() = default;
  /// Vertices in order, either way round; fewer than three make an outline that contains nothing.
  explicit Footprint(std::vector<Eigen::Vector2d> vertices);

  bool empty() const { return vertices_.empty(); }
  const std::vector<Eigen::Vector2d>& vertices() const { return vertices_; }
  bool contains(const Eigen::Vector2d& point) const;
  /// First entry and last exit of the ray; none if it only touches or misses the outline.
  std::optional<Crossing> crossing(const Eigen::Vector2d& origin, const Eigen::Vector2d& direction) const;
  /// Every edge moved outward by `margin` m (inward if negative).
  Footprint padded(double margin) const;
  /// The outline in another frame; heights are dropped.
  Footprint transformed(const Pose& pose) const;

 private:
  std::vector<Eigen::Vector2d> vertices_;  // counter-clockwise
};

}  // namespace lidard
