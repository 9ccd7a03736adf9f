// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/evidence/footprint.h"

#include <algorithm>
#include <cmath>

namespace lidard {
namespace {

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

double twice_area(const std::vector<Eigen::Vector2d>& v) {
  double sum = 0;
  for (std::size_t i = 0; i < v.size(); ++i) sum += cross(v[i], v[(i + 1) % v.size()]);
  return sum;
}

}  // namespace

Footprint::Footprint(std::vector<Eigen::Vector2d> vertices) : vertices_(std::move(vertices)) {
  if (vertices_.size() < 3) vertices_.clear();
  if (twice_area(vertices_) < 0) std::reverse(vertices_.begin(), vertices_.end());
}

bool Footprint::contains(const Eigen::Vector2d& point) const {
  bool inside = false;
  for (std::size_t i = 0, j = vertices_.size() - 1; i < vertices_.size(); j = i++) {
    const Eigen::Vector2d& a = vertices_[i];
    const Eigen::Vector2d& b = vertices_[j];
    if ((a.y() > point.y()) == (b.y() > point.y())) continue;
    if (point.x() < (b.x() - a.x()) * (point.y() - a.y()) / (b.y() - a.y()) + a.x()) inside = !inside;
  }
  return inside;
}

std::optional<Footprint::Crossing> Footprint::crossing(const Eigen::Vector2d& origin,
                                                       const Eigen::Vector2d& direction) const {
  double first = std::numeric_limits<double>::infinity();
  double last = -first;
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    const Eigen::Vector2d a = vertices_[i] - origin;
    const Eigen::Vector2d edge = vertices_[(i + 1) % vertices_.size()] - vertices_[i];
    const double slope = cross(direction, edge);
    if (std::abs(slope) < 1e-12) continue;
    const double along_edge = cross(a, direction) / slope;
    const double along_ray = cross(a, edge) / slope;
    if (along_edge < 0 || along_edge > 1 || along_ray < 0) continue;
    first = std::min(first, along_ray);
    last = std::max(last, along_ray);
  }
  if (contains(origin)) first = 0;
  if (!(last > first)) return std::nullopt;
  return Crossing{first, last};
}

Footprint Footprint::padded(double margin) const {
  std::vector<Eigen::Vector2d> moved;
  const std::size_t n = vertices_.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector2d before = (vertices_[i] - vertices_[(i + n - 1) % n]).normalized();
    const Eigen::Vector2d after = (vertices_[(i + 1) % n] - vertices_[i]).normalized();
    const Eigen::Vector2d normal_before(before.y(), -before.x());
    const Eigen::Vector2d normal_after(after.y(), -after.x());
    // The corner where both moved edges meet lies along the sum of their normals; at a spike that would be
    // far away, so it is cut at four margins.
    const Eigen::Vector2d sum = normal_before + normal_after;
    const double length = std::min(2 / std::max(sum.squaredNorm(), 1e-9), 4 / std::max(sum.norm(), 1e-9));
    moved.push_back(vertices_[i] + margin * length * sum);
  }
  return Footprint(std::move(moved));
}

Footprint Footprint::transformed(const Pose& pose) const {
  std::vector<Eigen::Vector2d> moved;
  for (const auto& v : vertices_) moved.push_back((pose * Eigen::Vector3d(v.x(), v.y(), 0)).head<2>());
  return Footprint(std::move(moved));
}

}  // namespace lidard
