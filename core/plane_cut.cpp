// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/plane_cut.h"

#include <algorithm>
#include <cmath>

namespace lidard {
namespace {

// What a return is to the plane.
enum Side : char { no_return = 0, below = 1, above_it = 2, side_mask = 3, on_ground = 4 };

// A virtual frame's plane less level than that (cosine) is crossed by no foot.
constexpr float steepest_plane = 0.3F;
// The ground may lie lower than it was taken for, m.
constexpr float ground_slack = 0.3F;
// A beam that is so high above the ground passes beneath things, m.
constexpr float passing_height = 0.1F;
// m from a face to a return on top of it; nearer than that the line between both does no harm.
constexpr float shallowest_step = 0.05F;

bool are_opposite(char a, char b) { return ((a | b) & side_mask) == side_mask; }

}  // namespace

void PlaneCut::set_cloud(const RingGrid& grid, const Ground& ground, const RingLinks& links,
                         const Eigen::Vector3f& up) {
  grid_ = &grid;
  ground_ = &ground;
  links_ = &links;
  up_ = up;
  const std::size_t cells = grid.kind.size();
  if (height_.capacity() < cells) {
    height_.reserve(cells + cells / 16);
    side_.reserve(cells + cells / 16);
  }
  height_.resize(cells);
  side_.resize(cells);
  for (Column* column : {&first_, &here_, &next_}) column->assign(grid.rings() + 1, {});
}

void PlaneCut::set_frame(const Pose& virtual_from_cloud, bool keep_ground) {
  keep_ground_ = keep_ground;
  rotation_ = virtual_from_cloud.linear().cast<float>();
  translation_ = virtual_from_cloud.translation().cast<float>();
  rise_ = rotation_.row(2).dot(up_);
  const Eigen::Vector3f n = rotation_.row(2).transpose();
  const float* const x = grid_->x.data();
  const float* const y = grid_->y.data();
  const float* const z = grid_->z.data();
  const float offset = translation_.z();
  float* const to = height_.data();
  const std::size_t cells = height_.size();
  for (std::size_t i = 0; i < cells; ++i) to[i] = n.x() * x[i] + n.y() * y[i] + n.z() * z[i] + offset;
}

void PlaneCut::set_level(float level) {
  level_ = level;
  const std::size_t cells = height_.size();
  const float* const height = height_.data();
  const Beam* const kind = grid_->kind.data();
  const char* const ground = ground_->is_ground.data();
  char* const side = side_.data();
  for (std::size_t i = 0; i < cells; ++i) {
    const int where = height[i] < level ? below : above_it;
    const int all = where + on_ground * ground[i];
    side[i] = static_cast<char>(kind[i] == Beam::point ? all : 0);
  }
}

/// Two returns between which a surface may be.
bool PlaneCut::is_surface(std::size_t a, std::size_t b) const {
  const int ground = (side_[a] & on_ground) + (side_[b] & on_ground);
  return ground == 0 || (keep_ground_ && ground == 2 * on_ground);
}

/// m from the sensor, level.
float PlaneCut::distance(std::size_t i) const {
  const float rise = ground_->height[i] - ground_->sensor;
  return std::sqrt(std::max(0.0F, grid_->range[i] * grid_->range[i] - rise * rise));
}

/// The beam whose end is `lower` passes between the ground and the return `upper`.
bool PlaneCut::passes_beneath(std::size_t lower, std::size_t upper) const {
  const float far = distance(lower);
  const float near = distance(upper);
  if (far <= near + links_->slack()) return false;
  const float height = ground_->sensor + (ground_->height[lower] - ground_->sensor) * (near / far);
  return height > passing_height;
}

bool PlaneCut::has_foot(std::size_t upper, std::size_t upper_ring) const {
  if (!ground_->known || (side_[upper] & on_ground) != 0 || rise_ < steepest_plane) return false;
  if (above(upper) / rise_ > ground_->height[upper] + ground_slack) return false;
  if (upper_ring == 0) return true;
  const Beam lower = grid_->kind[upper - 1];
  if (lower == Beam::unknown || lower == Beam::own) return true;
  return !passes_beneath(upper - 1, upper);
}

PlaneCut::Place PlaneCut::place(float x, float y, float z, float intensity, const Raster& raster) const {
  const float vx = rotation_(0, 0) * x + rotation_(0, 1) * y + rotation_(0, 2) * z + translation_.x();
  const float vy = rotation_(1, 0) * x + rotation_(1, 1) * y + rotation_(1, 2) * z + translation_.y();
  return {{vx, vy, intensity}, raster.position(vx, vy)};
}

/// Where the line between two returns on either side crosses the plane.
PlaneCut::Place PlaneCut::between(std::size_t a, std::size_t b, const Raster& raster) const {
  const RingGrid& g = *grid_;
  const float share = above(a) / (above(a) - above(b));
  const auto mixed = [&](const std::vector<float>& of) { return of[a] + share * (of[b] - of[a]); };
  return place(mixed(g.x), mixed(g.y), mixed(g.z), mixed(g.intensity), raster);
}

/// Where the plane is straight beneath or above a return.
PlaneCut::Place PlaneCut::straight_from(std::size_t i, const Raster& raster) const {
  const RingGrid& g = *grid_;
  const float drop = above(i) / rise_;
  return place(g.x[i] - drop * up_.x(), g.y[i] - drop * up_.y(), g.z[i] - drop * up_.z(), g.intensity[i],
               raster);
}

/// What is between a return and the one above it, which is farther away.
PlaneCut::Between PlaneCut::between_rings(std::size_t column, std::size_t upper) const {
  const std::size_t i = grid_->index(column, upper);
  const float step = distance(i) - distance(i - 1);
  if (rise_ < steepest_plane || step < std::max(2 * links_->slack(), shallowest_step)) return Between::slope;
  const bool lower_too = upper >= 2 && is_surface(i - 2, i - 1) && links_->upright(column, upper - 2);
  if (lower_too && links_->in_line(i - 2, i - 1, i)) return Between::slope;
  const bool higher_too =
      upper + 1 < grid_->rings() && is_surface(i, i + 1) && links_->upright(column, upper);
  if (higher_too && links_->in_line(i - 1, i, i + 1)) return Between::slope;
  return higher_too && distance(i + 1) - distance(i) < step / 2 ? Between::nothing : Between::top;
}

void PlaneCut::cross_column(std::size_t column, const Raster& raster, Column& crossings) const {
  const std::size_t first = grid_->index(column, 0);
  const std::size_t rings = grid_->rings();
  char lower = no_return;
  for (std::size_t r = 0; r < rings; ++r) {
    Crossing& crossing = crossings[r];
    crossing.exists = false;
    const char upper = side_[first + r];
    const char before = lower;
    lower = upper;
    const std::size_t i = first + r;
    if ((upper & side_mask) == no_return || ((upper & before) & side_mask) != 0) continue;
    const bool opposite = are_opposite(upper, before);
    if (!opposite && (upper & side_mask) != above_it) continue;
    const bool rises = (upper & side_mask) == above_it;
    const bool linked = opposite && is_surface(i - 1, i) && links_->upright(column, r - 1);
    const Between what = linked && rises ? between_rings(column, r) : Between::slope;
    if (linked && what != Between::nothing) {
      const bool top = what == Between::top;
      crossing = {top ? straight_from(i - 1, raster) : between(i - 1, i, raster), {}, true, false, 0};
    } else if (rises && has_foot(i, r)) {
      crossing = {straight_from(i, raster), {}, true, true, 0};
    }
  }
}

/// Where the plane crosses the surface between a return and that of the same ring in the next column.
bool PlaneCut::cross_level(std::size_t column, std::size_t ring, const Raster& raster, Place& at) const {
  const std::size_t a = grid_->index(column, ring);
  const std::size_t b = grid_->index(grid_->after(column), ring);
  if (!are_opposite(side_[a], side_[b]) || !is_surface(a, b) || !links_->level(column, ring)) return false;
  at = between(a, b, raster);
  return true;
}

void PlaneCut::join(Crossing* a, const Place& at_a, Crossing* b, const Place& at_b,
                    const Target& target) const {
  target.raster.draw_segment(at_a.point, at_b.point, at_a.beam, at_b.beam, target.layer);
  if (a != nullptr) ++a->segments, a->neighbour = at_b;
  if (b != nullptr) ++b->segments, b->neighbour = at_a;
}

/// Draws what is between two neighbouring columns: cell by cell the line between the two edges that the plane
/// crosses.
void PlaneCut::connect(std::size_t column, Column& here, Column& next, const Target& target) const {
  Place bottom{};
  Place top{};
  bool has_bottom = false;
  const char* const side = side_.data() + grid_->index(column, 0);
  const char* const beside = side_.data() + grid_->index(grid_->after(column), 0);
  for (std::size_t r = 0; r < grid_->rings(); ++r) {
    const bool turns = are_opposite(side[r], beside[r]);
    if (!turns && !has_bottom && !here[r].exists && !next[r].exists) continue;
    const bool has_top = turns && cross_level(column, r, target.raster, top);
    Crossing* const left = here[r].exists ? &here[r] : nullptr;
    Crossing* const right = next[r].exists ? &next[r] : nullptr;
    if (left != nullptr && right != nullptr && !has_top && !has_bottom) {
      const bool lower = !left->foot && !right->foot && links_->level(column, r - 1);
      if (lower || links_->level(column, r)) join(left, left->at, right, right->at, target);
    } else {
      // Where all four edges are crossed, the lines turn round the lower left and the upper right corner.
      if (left != nullptr && has_bottom) join(left, left->at, nullptr, bottom, target);
      if (right != nullptr && has_top) join(right, right->at, nullptr, top, target);
      if (left != nullptr && has_top && !has_bottom) join(left, left->at, nullptr, top, target);
      if (right != nullptr && has_bottom && !has_top) join(right, right->at, nullptr, bottom, target);
      if (left == nullptr && right == nullptr && has_top && has_bottom)
        join(nullptr, bottom, nullptr, top, target);
    }
    bottom = top;
    has_bottom = has_top;
  }
}

/// What ends here or stands alone also counts in the beam nearest to it.
void PlaneCut::flush(const Column& crossings, const Target& target) const {
  for (std::size_t r = 0; r < grid_->rings(); ++r) {
    const Crossing& one = crossings[r];
    if (!one.exists || one.segments > 1) continue;
    const Raster::Point& p = one.at.point;
    if (one.segments == 0)
      target.raster.draw_point(p, one.at.beam, target.layer);
    else
      target.raster.draw_end(p, one.neighbour.point, one.at.beam, target.layer);
    const float dx = p.x - translation_.x();
    const float dy = p.y - translation_.y();
    const float width = static_cast<float>(grid_->step()) * std::sqrt(dx * dx + dy * dy);
    target.raster.mark_near(p, one.at.beam, width, target.marks);
  }
}

void PlaneCut::draw_slice(float level, const Raster& raster, RangeLayer& layer, std::vector<char>& marks) {
  const Target target{raster, layer, marks};
  set_level(level);
  cross_column(0, raster, first_);
  here_ = first_;
  for (std::size_t c = 0; c < grid_->columns(); ++c) {
    if (c + 1 < grid_->columns()) {
      cross_column(c + 1, raster, next_);
      connect(c, here_, next_, target);
    } else {
      connect(c, here_, first_, target);
    }
    if (c == 0)
      first_ = here_;  // its other side comes last
    else
      flush(here_, target);
    std::swap(here_, next_);
  }
  flush(first_, target);
}

void PlaneCut::draw_clipped(std::size_t a, std::size_t b, HeightBand band, const Target& target) const {
  const float za = height_[a];
  const float zb = height_[b];
  const auto low = static_cast<float>(band.min);
  const auto high = static_cast<float>(band.max);
  if ((za < low && zb < low) || (za > high && zb > high)) return;
  const auto share_at = [&](float z, float limit) { return z == limit ? 0.0F : (limit - za) / (zb - za); };
  const float from = za < low ? share_at(za, low) : za > high ? share_at(za, high) : 0.0F;
  const float to = zb < low ? share_at(zb, low) : zb > high ? share_at(zb, high) : 1.0F;
  const RingGrid& g = *grid_;
  const auto at = [&](float share) {
    const auto mixed = [&](const std::vector<float>& of) { return of[a] + share * (of[b] - of[a]); };
    return place(mixed(g.x), mixed(g.y), mixed(g.z), mixed(g.intensity), target.raster);
  };
  const Place p = at(from);
  const Place q = at(to);
  target.raster.draw_segment(p.point, q.point, p.beam, q.beam, target.layer);
}

void PlaneCut::draw_edges(HeightBand band, const Target& target) const {
  const RingGrid& g = *grid_;
  for (std::size_t c = 0; c < g.columns(); ++c) {
    const std::size_t next = g.after(c);
    const std::size_t before = c > 0 ? c - 1 : g.columns() - 1;
    for (std::size_t r = 0; r < g.rings(); ++r) {
      const std::size_t i = g.index(c, r);
      if (g.kind[i] != Beam::point || ((side_[i] & on_ground) != 0 && !keep_ground_)) continue;
      const std::size_t beside = g.index(next, r);
      const bool level = is_surface(i, beside) && links_->level(c, r);
      const bool upright = r + 1 < g.rings() && is_surface(i, i + 1) && links_->upright(c, r);
      if (level) draw_clipped(i, beside, band, target);
      if (upright) draw_clipped(i, i + 1, band, target);
      const auto height = static_cast<double>(height_[i]);
      if (level || upright || height < band.min || height > band.max) continue;
      if (links_->level(before, r) || (r > 0 && links_->upright(c, r - 1))) continue;
      const Place p = place(g.x[i], g.y[i], g.z[i], g.intensity[i], target.raster);
      target.raster.draw_point(p.point, p.beam, target.layer);
    }
  }
}

void PlaneCut::draw_band(HeightBand band, const Raster& raster, RangeLayer& layer, std::vector<char>& marks) {
  const Target target{raster, layer, marks};
  set_level(0);
  if (std::isfinite(band.min)) draw_slice(static_cast<float>(band.min), raster, layer, marks);
  if (std::isfinite(band.max)) draw_slice(static_cast<float>(band.max), raster, layer, marks);
  draw_edges(band, target);
}

}  // namespace lidard
