// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/virtual/plane_cut.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/bytes.h"
#include "core/base/clones.h"

namespace lidard {
namespace {

// m by which the ground may lie lower than assumed.
constexpr float ground_slack = 0.3F;
// m; a beam at least this high above the ground passes beneath objects.
constexpr float passing_height = 0.1F;
// m from a face to a return on top of it; at shorter steps a slope between both is accurate enough.
constexpr float shallowest_step = 0.05F;

}  // namespace

/// True if the beam that ends at `lower` passes between the ground and the return `upper`.
bool PlaneCut::passes_beneath(std::size_t lower, std::size_t upper) const {
  const float far = view_->distance(lower);
  const float near = view_->distance(upper);
  if (far <= near + view_->links().slack()) return false;
  const Ground& ground = view_->ground();
  return ground.sensor + (ground.height[lower] - ground.sensor) * (near / far) > passing_height;
}

bool PlaneCut::has_foot(std::size_t upper, std::size_t upper_ring) const {
  const Ground& ground = view_->ground();
  const bool on_ground = (view_->sides()[upper] & PlaneView::on_ground) != 0;
  if (!ground.known || on_ground || view_->rise() < PlaneView::steepest) return false;
  if (view_->above(upper) / view_->rise() > ground.height[upper] + ground_slack) return false;
  if (upper_ring == 0) return true;
  const Beam lower = view_->grid().kind[upper - 1];
  if (lower == Beam::unknown || lower == Beam::own) return true;
  return !passes_beneath(upper - 1, upper);
}

/// The surface between a return and the one above it, which is farther away.
PlaneCut::Between PlaneCut::between_rings(std::size_t column, std::size_t upper) const {
  const RingLinks& links = view_->links();
  const std::size_t rings = view_->grid().rings();
  const std::size_t i = view_->grid().index(column, upper);
  const float step = view_->distance(i) - view_->distance(i - 1);
  if (view_->rise() < PlaneView::steepest || step < std::max(2 * links.slack(), shallowest_step))
    return Between::slope;
  const bool lower_too = upper >= 2 && view_->is_surface(i - 2, i - 1) && links.upright(column, upper - 2);
  if (lower_too && links.in_line(i - 2, i - 1, i)) return Between::slope;
  const bool higher_too = upper + 1 < rings && view_->is_surface(i, i + 1) && links.upright(column, upper);
  if (higher_too && links.in_line(i - 1, i, i + 1)) return Between::slope;
  const bool face = higher_too && view_->distance(i + 1) - view_->distance(i) < step / 2;
  return face ? Between::nothing : Between::top;
}

LIDARD_CLONES void PlaneCut::find_events() {
  const RingGrid& grid = view_->grid();
  const std::size_t cells = grid.kind.size();
  resize_amply(cells, events_);
  const std::uint8_t* const sides = view_->sides().data();
  const std::uint8_t* const verdicts = tops_->verdicts().data();
  std::uint8_t* const events = events_.data();
  for (std::size_t i = 1; i < cells; ++i) {
    const int rises = (sides[i] & ~sides[i - 1] & PlaneView::above_it) >> 1;
    const int falls = sides[i] & (sides[i - 1] >> 1) & PlaneView::below;
    const int verdict = verdicts[i] & 1;  // reaches or hides
    events[i] = static_cast<std::uint8_t>(rises | falls | verdict);
  }
  for (std::size_t i = 0; i < cells; i += grid.rings())
    events[i] = static_cast<std::uint8_t>(sides[i] & PlaneView::above_it);
}

void PlaneCut::add(const Raster::Point& at, std::size_t ring, bool foot) {
  crossings_.push_back({at, {}, static_cast<std::uint32_t>(ring), foot, 0});
}

void PlaneCut::cross(std::size_t column, std::size_t ring) {
  const PlaneView& view = *view_;
  const std::size_t i = view.grid().index(column, ring);
  const std::uint8_t upper = view.sides()[i];
  const std::uint8_t lower = ring > 0 ? view.sides()[i - 1] : std::uint8_t{PlaneView::no_return};
  const std::uint8_t verdict = tops_->verdicts()[i];
  const bool opposite = PlaneView::are_opposite(upper, lower);
  const bool rises = (upper & PlaneView::above_it) != 0 && (lower & PlaneView::above_it) == 0;
  const bool falls = opposite && !rises;
  const bool may_link = opposite || verdict == PlaneTops::hides;
  const bool linked = may_link && view.is_surface(i - 1, i) && view.links().upright(column, ring - 1);
  const Between what = linked && rises ? between_rings(column, ring) : Between::slope;
  if (linked && (rises || falls) && what != Between::nothing)
    add(what == Between::top ? view.straight_from(i - 1) : view.between(i - 1, i), ring, false);
  else if (verdict == PlaneTops::reaches && (lower & PlaneView::below) != 0)
    add(view.straight_from(i - 1), ring, false);
  else if ((rises || (verdict == PlaneTops::hides && !linked)) && has_foot(i, ring))
    add(view.straight_from(i), ring, true);
}

/// Where the plane crosses the surface between a return and that of the same ring in the next column.
bool PlaneCut::cross_level(std::size_t column, std::size_t ring, PlanePoint& at) const {
  const RingGrid& grid = view_->grid();
  const std::size_t a = grid.index(column, ring);
  const std::size_t b = grid.index(grid.after(column), ring);
  if (!PlaneView::are_opposite(view_->sides()[a], view_->sides()[b])) return false;
  if (!view_->is_surface(a, b) || !view_->links().level(column, ring)) return false;
  at.point = view_->between(a, b);
  at.beam = raster_->position(at.point.x, at.point.y);
  return true;
}

void PlaneCut::join(std::size_t a, const PlanePoint& at_a, std::size_t b, const PlanePoint& at_b) {
  raster_->draw_segment(at_a.point, at_b.point, at_a.beam, at_b.beam, *layer_);
  if (a != no_crossing) ++crossings_[a].segments, crossings_[a].neighbour = at_b.point;
  if (b != no_crossing) ++crossings_[b].segments, crossings_[b].neighbour = at_a.point;
}

/// True if a ring's returns in this column and the next one lie on opposite sides of the plane.
bool PlaneCut::turns_between(std::size_t column) const {
  const std::size_t rings = view_->grid().rings();
  const std::uint8_t* const here = view_->sides().data() + view_->grid().index(column, 0);
  const std::uint8_t* const next = here + rings;
  int turns = 0;
  for (std::size_t r = 0; r < rings; ++r) {
    const int both = here[r] | next[r];
    turns |= both & (both >> 1) & 1;
  }
  return turns != 0;
}

/// True if two crossings of one ring in neighbouring columns belong to one surface.
bool PlaneCut::go_together(std::size_t column, const Crossing& left, const Crossing& right) const {
  const bool lower = !left.foot && !right.foot && view_->links().level(column, left.ring - 1);
  return lower || view_->links().level(column, left.ring);
}

/// Draws the cut between two neighbouring columns: for every cell the line between the two edges that the
/// plane crosses.
void PlaneCut::connect(std::size_t column) {
  if (turns_between(column)) {
    connect_turning(column);
    return;
  }
  const std::size_t next = view_->grid().after(column);
  std::size_t left = firsts_[column];
  std::size_t right = firsts_[next];
  const std::size_t left_end = firsts_[column + 1];
  const std::size_t right_end = firsts_[next + 1];
  while (left < left_end && right < right_end) {
    const Crossing& a = crossings_[left];
    const Crossing& b = crossings_[right];
    if (a.ring == b.ring && go_together(column, a, b)) join(left, point_of(left), right, point_of(right));
    const bool skip_left = a.ring <= b.ring;
    const bool skip_right = b.ring <= a.ring;
    left += skip_left ? 1 : 0;
    right += skip_right ? 1 : 0;
  }
}

void PlaneCut::connect_turning(std::size_t column) {
  const std::size_t next = view_->grid().after(column);
  std::size_t here = firsts_[column];
  std::size_t beside = firsts_[next];
  const std::size_t here_end = firsts_[column + 1];
  const std::size_t beside_end = firsts_[next + 1];
  PlanePoint bottom{};
  PlanePoint top{};
  bool has_bottom = false;
  for (std::size_t r = 0; r < view_->grid().rings(); ++r) {
    const bool has_top = cross_level(column, r, top);
    const std::size_t left = here < here_end && crossings_[here].ring == r ? here++ : no_crossing;
    const std::size_t right = beside < beside_end && crossings_[beside].ring == r ? beside++ : no_crossing;
    if (left != no_crossing && right != no_crossing && !has_top && !has_bottom) {
      if (go_together(column, crossings_[left], crossings_[right]))
        join(left, point_of(left), right, point_of(right));
    } else {
      // If all four edges are crossed, the lines separate the lower left and the upper right corner.
      if (left != no_crossing && has_bottom) join(left, point_of(left), no_crossing, bottom);
      if (right != no_crossing && has_top) join(right, point_of(right), no_crossing, top);
      if (left != no_crossing && has_top && !has_bottom) join(left, point_of(left), no_crossing, top);
      if (right != no_crossing && has_bottom && !has_top) join(right, point_of(right), no_crossing, bottom);
      if (left == no_crossing && right == no_crossing && has_top && has_bottom)
        join(no_crossing, bottom, no_crossing, top);
    }
    bottom = top;
    has_bottom = has_top;
  }
}

/// Draws the end of a line or a single crossing into the beam nearest to it.
void PlaneCut::flush(std::size_t crossing) const {
  const Crossing& one = crossings_[crossing];
  if (one.segments > 1) return;
  const float at = beams_[crossing];
  if (one.segments == 0)
    raster_->draw_point(one.at, at, *layer_);
  else
    raster_->draw_end(one.at, one.neighbour, at, *layer_);
}

void PlaneCut::draw_slice(const PlaneView& view, const PlaneTops& tops, const Raster& raster,
                          RangeLayer& layer) {
  view_ = &view;
  tops_ = &tops;
  raster_ = &raster;
  layer_ = &layer;
  const RingGrid& grid = view.grid();
  find_events();
  crossings_.clear();
  firsts_.resize(grid.columns() + 1);
  for (std::size_t c = 0; c < grid.columns(); ++c) {
    firsts_[c] = static_cast<std::uint32_t>(crossings_.size());
    each_set(events_.data() + grid.index(c, 0), grid.rings(), [&](std::size_t r) { cross(c, r); });
  }
  firsts_[grid.columns()] = static_cast<std::uint32_t>(crossings_.size());
  x_.resize(crossings_.size());
  y_.resize(crossings_.size());
  beams_.resize(crossings_.size());
  for (std::size_t k = 0; k < crossings_.size(); ++k) {
    x_[k] = crossings_[k].at.x;
    y_[k] = crossings_[k].at.y;
  }
  raster.positions(x_.data(), y_.data(), x_.size(), beams_.data());
  for (std::size_t c = 0; c < grid.columns(); ++c) connect(c);
  for (std::size_t k = 0; k < crossings_.size(); ++k) flush(k);
}

/// Adds the part of the line between two returns whose height is in the band.
void PlaneCut::add_clipped(std::size_t a, std::size_t b, float low, float high) {
  const float za = view_->heights()[a];
  const float zb = view_->heights()[b];
  if ((za < low && zb < low) || (za > high && zb > high)) return;
  const auto share_at = [&](float z, float limit) { return z == limit ? 0.0F : (limit - za) / (zb - za); };
  const float from = za < low ? share_at(za, low) : za > high ? share_at(za, high) : 0.0F;
  const float to = zb < low ? share_at(zb, low) : zb > high ? share_at(zb, high) : 1.0F;
  const BeamEnd& begin = view_->grid().ends[a];
  const BeamEnd& end = view_->grid().ends[b];
  lines_.push_back({view_->project(mixed(begin, end, from)), view_->project(mixed(begin, end, to))});
}

void PlaneCut::add_edges(std::size_t column, HeightBand band) {
  const RingGrid& grid = view_->grid();
  const RingLinks& links = view_->links();
  const auto low = static_cast<float>(band.min), high = static_cast<float>(band.max);
  const std::size_t before = column > 0 ? column - 1 : grid.columns() - 1;
  for (std::size_t r = 0; r < grid.rings(); ++r) {
    const std::size_t i = grid.index(column, r);
    const bool on_ground = (view_->sides()[i] & PlaneView::on_ground) != 0;
    if (grid.kind[i] != Beam::point || on_ground) continue;
    const std::size_t beside = grid.index(grid.after(column), r), above = r + 1 < grid.rings() ? i + 1 : i;
    const std::array<float, 3> heights = {view_->heights()[i], view_->heights()[beside],
                                          view_->heights()[above]};
    if (std::max({heights[0], heights[1], heights[2]}) < low) continue;
    if (std::min({heights[0], heights[1], heights[2]}) > high) continue;
    const bool level = view_->is_surface(i, beside) && links.level(column, r);
    const bool upright = above != i && view_->is_surface(i, above) && links.upright(column, r);
    if (level) add_clipped(i, beside, low, high);
    if (upright) add_clipped(i, above, low, high);
    const auto height = static_cast<double>(heights[0]);
    if (level || upright || height < band.min || height > band.max) continue;
    if (links.level(before, r) || (r > 0 && links.upright(column, r - 1))) continue;
    const Raster::Point point = view_->project(grid.ends[i]);
    raster_->draw_point(point, *layer_);
  }
}

void PlaneCut::draw_edges(const PlaneView& view, HeightBand band, const Raster& raster, RangeLayer& layer) {
  view_ = &view;
  raster_ = &raster;
  layer_ = &layer;
  lines_.clear();
  for (std::size_t c = 0; c < view.grid().columns(); ++c) add_edges(c, band);
  const std::size_t count = 2 * lines_.size();
  for (auto* list : {&x_, &y_, &beams_}) list->resize(count);
  for (std::size_t k = 0; k < lines_.size(); ++k) {
    x_[2 * k] = lines_[k].from.x, x_[2 * k + 1] = lines_[k].to.x;
    y_[2 * k] = lines_[k].from.y, y_[2 * k + 1] = lines_[k].to.y;
  }
  raster.positions(x_.data(), y_.data(), count, beams_.data());
  for (std::size_t k = 0; k < lines_.size(); ++k)
    raster.draw_segment(lines_[k].from, lines_[k].to, beams_[2 * k], beams_[2 * k + 1], layer);
}

}  // namespace lidard
