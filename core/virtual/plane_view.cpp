// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/virtual/plane_view.h"

#include <algorithm>

#include "core/base/bytes_set.h"

namespace lidard {

void PlaneView::set_cloud(const RingGrid& grid, const Ground& ground, const RingLinks& links,
                          const Eigen::Vector3f& up) {
  grid_ = &grid;
  ground_ = &ground;
  links_ = &links;
  up_ = up;
  const std::size_t cells = grid.kind.size();
  resize_amply(cells, heights_);
  resize_amply(cells + grid.rings(), sides_);
}

void PlaneView::set_frame(const Pose& virtual_from_cloud, bool keep_ground) {
  keep_ground_ = keep_ground;
  rotation_ = virtual_from_cloud.linear().cast<float>();
  translation_ = virtual_from_cloud.translation().cast<float>();
  rise_ = rotation_.row(2).dot(up_);
  const float x = rotation_(2, 0), y = rotation_(2, 1), z = rotation_(2, 2), offset = translation_.z();
  const BeamEnd* const ends = grid_->ends.data();
  float* const to = heights_.data();
  const std::size_t cells = heights_.size();
  for (std::size_t i = 0; i < cells; ++i) to[i] = x * ends[i].x + y * ends[i].y + z * ends[i].z + offset;
}

void PlaneView::set_level(float level) {
  level_ = level;
  const std::size_t cells = heights_.size();
  const float* const heights = heights_.data();
  const Beam* const kinds = grid_->kind.data();
  const char* const grounds = ground_->is_ground.data();
  std::uint8_t* const sides = sides_.data();
  for (std::size_t i = 0; i < cells; ++i) {
    const int where = heights[i] < level ? below : above_it;
    const int all = where + on_ground * grounds[i];
    sides[i] = static_cast<std::uint8_t>(kinds[i] == Beam::point ? all : 0);
  }
  std::copy_n(sides, grid_->rings(), sides + cells);
}

Raster::Point PlaneView::place(const BeamEnd& end) const {
  const auto& r = rotation_;
  return {r(0, 0) * end.x + r(0, 1) * end.y + r(0, 2) * end.z + translation_.x(),
          r(1, 0) * end.x + r(1, 1) * end.y + r(1, 2) * end.z + translation_.y(), end.intensity};
}

Raster::Point PlaneView::between(std::size_t a, std::size_t b) const {
  return place(mixed(grid_->ends[a], grid_->ends[b], above(a) / (above(a) - above(b))));
}

Raster::Point PlaneView::straight_from(std::size_t i) const {
  const float drop = above(i) / rise_;
  BeamEnd end = grid_->ends[i];
  end.x -= drop * up_.x();
  end.y -= drop * up_.y();
  end.z -= drop * up_.z();
  return place(end);
}

}  // namespace lidard
