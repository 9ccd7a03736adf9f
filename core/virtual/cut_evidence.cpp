// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/virtual/cut_evidence.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/bytes.h"
#include "core/base/clones.h"

namespace lidard {
namespace {

constexpr float infinite = std::numeric_limits<float>::infinity();
// sine; in a plane that leans more, the beams of one column have different directions.
constexpr float level_enough = 0.02F;
// Share of the distance; the ends of two columns that differ less are one border.
constexpr float same_border = 0.03F;
constexpr float in_plane = 0.001F;  // m
constexpr float shortest = 0.002F;  // m; a shorter piece is a point
constexpr std::array every_kind = {Visibility::seen, Visibility::blind, Visibility::over, Visibility::front};
// Columns without any beam that may lie between two of one strip.
constexpr std::size_t most_silent = 1;

}  // namespace

/// Measures the beams of a column in the plane.
LIDARD_CLONES void CutEvidence::measure_column(std::size_t column) {
  const RingGrid& grid = view_->grid();
  const std::size_t rings = rings_;
  base_ = grid.index(column, 0);
  if (grid.moved) look_from(grid.origins[column]);
  const Beam* const kinds = grid.kind.data() + base_;
  const float* const heights = view_->heights().data() + base_;
  const char* const grounds = view_->ground().is_ground.data() + base_;
  std::uint8_t* const marks = marks_.data();
  float* const ends = ends_.data();
  float* const beneath = beneath_.data();
  float* const crossings = crossings_.data();
  if (grid.moved)
    view_->measure_reaches(column, at_, ends);
  else
    std::copy_n(view_->reaches().data() + base_, rings, ends);
  const float level = view_->level(), sensor = sensor_, sign = sign_;
  for (std::size_t r = 0; r < rings; ++r) {
    const float under = sign * (level - heights[r]);
    beneath[r] = under;
    crossings[r] = ends[r] * sensor / std::max(sensor + under, 1e-6F);
  }
  for (std::size_t r = 0; r < rings; ++r) {
    const int point = kinds[r] == Beam::point ? 1 : 0;
    const int ended = point | (kinds[r] == Beam::none ? 1 : 0);
    const int thing = point & (grounds[r] == Ground::sure ? 0 : 1);
    const int beyond = beneath[r] > 0 ? 1 : 0;
    marks[r] =
        static_cast<std::uint8_t>(known * ended | hits * point | stands * thing | crosses * (ended & beyond));
  }
  for (; lone_ != lone_end_ && lone_->beam < base_ + rings; ++lone_) show_lone_return(*lone_);
}

/// In place of a lone return, the beam by which it is shown counts.
void CutEvidence::show_lone_return(const RingLinks::LoneReturn& one) {
  const std::size_t r = one.beam - base_, i = one.shown_by;
  ends_[r] = reach_of(view_->project(view_->grid().ends[i]));
  beneath_[r] = -sign_ * view_->above(i);
  crossings_[r] = ends_[r] * sensor_ / std::max(sensor_ + beneath_[r], 1e-6F);
  const bool hit = view_->grid().kind[i] == Beam::point;
  const bool thing = hit && view_->ground().is_ground[i] != Ground::sure;
  marks_[r] = static_cast<std::uint8_t>(known | lone | (hit ? hits : 0) | (thing ? stands : 0) |
                                        (beneath_[r] > 0 ? crosses : 0));
}

/// Where a beam that does not cross the plane ends.
CutEvidence::End CutEvidence::end_at(std::size_t ring) const {
  if ((marks_[ring] & (known | crosses)) != known) return {infinite, false};
  return {ends_[ring], (marks_[ring] & hits) != 0};
}

/// The object that the crossing beam `last` hits beyond the plane, if it may reach the plane under the next
/// beam. The ground does not, nor does an object that is known to be lower.
CutEvidence::End CutEvidence::thing_at(std::size_t last, std::size_t next) const {
  if ((marks_[last] & stands) == 0 || verdict(next) == PlaneTops::stays_below) return {infinite, true};
  return {ends_[last], true};
}

/// Adds a piece that begins at `from` m, where ring `first` crosses the plane or farther away, and ends in
/// the direction of ring `along`.
void CutEvidence::add(Visibility::Kind kind, float from, std::size_t first, std::size_t along, End end) {
  if (end.at > reach_) end = {reach_, false};
  if (!(end.at - from > shortest)) return;
  std::vector<Piece>& column = strips_[kind].column;
  // A column's pieces begin farther and farther away. Those that overlap are one.
  if (tilted_ || column.empty() || from > column.back().end.at) {
    column.push_back({from, end, base_ + first, base_ + along});
  } else if (end.at > column.back().end.at) {
    column.back().end = end;
    column.back().last = base_ + along;
  }
}

/// Transforms a piece to the frame; false if it has no direction there, as that of a beam straight down.
bool CutEvidence::transform(const Piece& piece, OutlineBeam& way) const {
  float ux = 0, uy = 0;
  if (!direct(piece.last, ux, uy)) return false;
  way.ox = at_.x, way.oy = at_.y;
  way.ux = ux, way.uy = uy;
  way.from = piece.from;
  way.length = piece.end.at;
  way.hides = piece.end.hides;
  way.x = at_.x + ux * piece.end.at, way.y = at_.y + uy * piece.end.at;
  if (tilted_ && piece.from > 0 && piece.first != piece.last && !direct(piece.first, ux, uy)) return false;
  way.bx = at_.x + ux * piece.from, way.by = at_.y + uy * piece.from;
  return true;
}

/// Sets the direction of a beam in the plane.
bool CutEvidence::direct(std::size_t beam, float& ux, float& uy) const {
  const Raster::Point to = view_->project(view_->grid().ends[beam]);
  const float reach = reach_of(to);
  if (!(reach > shortest)) return false;
  ux = (to.x - at_.x) / reach, uy = (to.y - at_.y) / reach;
  return true;
}

/// Adds the blind part of a column whose lowest beams do not cross the plane or have different directions.
void CutEvidence::add_blind(std::size_t lowest) {
  const End end = end_at(lowest);
  const bool ends = end.at < crossings_[lowest] && end.hides;
  const std::size_t next = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(lowest) + step_);
  const bool top_alone = ends && next < rings_ && verdict(next) == PlaneTops::top_alone;
  add(top_alone ? Visibility::front : Visibility::blind, 0, lowest, lowest,
      {ends ? end.at : std::max(crossings_[lowest], looked_from_), ends});
}

/// m to the nearest object of the column between the heights of the band.
float CutEvidence::wall_in_band() const {
  if (!(band_.max > band_.min)) return infinite;
  float nearest = infinite;
  for (std::size_t r = 0; r < rings_; ++r) {
    const float height = view_->level() - sign_ * beneath_[r];
    const bool counts = (marks_[r] & (stands | lone)) == stands && height >= static_cast<float>(band_.min) &&
                        height <= static_cast<float>(band_.max);
    if (counts) nearest = std::min(nearest, ends_[r]);
  }
  return nearest;
}

/// m from where on the column's beams have looked at all of the band: nearer its upper limit is above the
/// topmost beam of a lidar that stands in the band.
float CutEvidence::whole_band_from() const {
  const float sensor = view_->level() + sign_ * sensor_;
  const auto top = static_cast<float>(band_.max), bottom = static_cast<float>(band_.min);
  if (!(bottom < sensor && sensor < top && std::isfinite(top))) return 0;
  for (std::size_t r = rings_; r-- > 0;) {
    if ((marks_[r] & known) == 0) continue;
    const float rise = -sign_ * (beneath_[r] + sensor_);
    return rise > 0 ? ends_[r] * (top - sensor) / rise : infinite;
  }
  return infinite;
}

void CutEvidence::look_from(const BeamEnd& origin) {
  at_ = view_->project(origin);
  // In a plane through the sensor every beam that leaves it does so at the sensor.
  const float above = std::max(sign_ * view_->above(origin), 0.0F);
  sensor_ = above < in_plane ? 0 : above;
}

/// Finds the pieces of a column; false if it has no beam.
bool CutEvidence::find_column(std::size_t column) {
  measure_column(column);
  farthest_ = wall_in_band();
  looked_from_ = whole_band_from();
  const auto mark = [&](std::size_t k) { return marks_[ring(k)]; };
  const auto thing_before = [&](std::size_t next, std::size_t last) {
    return next < rings_ ? thing_at(last, ring(next)) : End{infinite, true};
  };
  std::size_t k = 0;
  while (k < rings_ && mark(k) == 0) ++k;
  if (k == rings_) return false;
  const bool in_line = (mark(k) & crosses) != 0 && !tilted_ && view_->grid().fired_in_columns();
  if (!in_line && beneath_[ring(k)] + sensor_ > 0) add_blind(ring(k));
  for (bool nearest = in_line;; nearest = false) {
    while (k < rings_ && (mark(k) & crosses) == 0) ++k;
    if (k == rings_) return true;
    std::size_t first = ring(k);
    if (nearest) add(Visibility::blind, 0, first, first, {std::max(crossings_[first], looked_from_), false});
    std::size_t last = ring(k++);
    End thing = thing_before(k, last);
    for (; k < rings_ && (mark(k) & crosses) != 0; last = ring(k++), thing = thing_before(k, last)) {
      if (thing.at < infinite) break;
      if (!tilted_) continue;
      const std::size_t next = ring(k);
      add(Visibility::seen, crossings_[first], first, next, {crossings_[next], false});
      first = next;
    }
    end_piece(first, last, k < rings_ && mark(k) != 0 ? ring(k) : last, thing);
  }
}

/// `next`: the neighbour of the last crossing ring, or `last` itself if nothing is known of the neighbour.
void CutEvidence::end_piece(std::size_t first, std::size_t last, std::size_t next, End thing) {
  const bool crosses_too = next == last || (marks_[next] & crosses) != 0;
  End end = crosses_too ? End{crossings_[next], false} : end_at(next);
  // The last ring passed beneath an object that is nearer than its crossing.
  end.at = std::max(end.at, crossings_[last]);
  const bool ended = next != last && thing.at < end.at;
  End free_end = ended ? End{std::max(crossings_[last], thing.at), true} : end;
  if (free_end.at > farthest_) free_end = {farthest_, true};
  add(Visibility::seen, std::max(crossings_[first], looked_from_), first, next, free_end);
  if (crosses_too && ended && verdict(next) == PlaneTops::likely_below && free_end.at <= end.at)
    add(Visibility::over, free_end.at, first, next, {end.at, false});
}

bool CutEvidence::are_joined(const Piece& a, const Piece& b, Visibility::Kind kind) const {
  if (tilted_ && kind == Visibility::seen) return a.first % rings_ == b.first % rings_;
  return a.from <= b.end.at && b.from <= a.end.at;
}

/// True if the free space of two columns has a straight border.
bool CutEvidence::is_straight(const Piece& a, const Piece& b, Visibility::Kind kind) const {
  if (kind != Visibility::seen && !a.end.hides && !b.end.hides) return true;
  if (std::fabs(a.end.at - b.end.at) <= same_border * std::min(a.end.at, b.end.at)) return true;
  return a.end.hides && b.end.hides && a.last + rings_ == b.last && view_->links().level_at(a.last);
}

void CutEvidence::add_strip(Visibility::Kind kind, std::vector<OutlineBeam>& beams, Outlines::Side begin,
                            Outlines::Side end) {
  if (clockwise_) {
    std::reverse(beams.begin(), beams.end());
    for (std::size_t i = 0; i + 1 < beams.size(); ++i) beams[i].to_next = beams[i + 1].to_next;
    std::swap(begin, end);
  }
  const double step = view_->grid().step();
  visibility_->outlines(lidar_, kind, step, static_cast<double>(std::hypot(at_.x, at_.y)))
      .add_strip(beams, static_cast<float>(step), begin, end);
}

void CutEvidence::begin_strip(Strips& strips, const Piece& piece, Outlines::Side begin) const {
  if (strips.count == strips.open.size()) strips.open.emplace_back();
  Strip& strip = strips.open[strips.count++];
  strip.beams.assign(1, way_);
  strip.next = piece;
  strip.begin = begin;
  strip.goes_on = true;
}

/// Joins the pieces of the current column with the strips of the columns before. Where two pieces overlap one
/// of the next column, or the other way round, one of them goes on and the other one is joined by a strip of
/// two beams.
void CutEvidence::join_column(Visibility::Kind kind) {
  Strips& strips = strips_[kind];
  const std::size_t before = strips.count;
  for (std::size_t s = 0; s < before; ++s) strips.open[s].goes_on = strips.open[s].has_branch = false;
  for (const Piece& piece : strips.column) {
    if (!transform(piece, way_)) continue;
    bool has_strip = false, is_branch = false;
    for (std::size_t s = 0; s < before; ++s) {
      Strip& strip = strips.open[s];
      if (!are_joined(strip.newest, piece, kind)) continue;
      const bool straight = is_straight(strip.newest, piece, kind);
      if (!strip.goes_on && !has_strip) {
        strip.beams.back().to_next = straight;
        strip.beams.push_back(way_);
        strip.next = piece;
        strip.goes_on = has_strip = true;
      } else {
        pair_.assign({strip.beams.rbegin()[strip.goes_on ? 1 : 0], way_});
        pair_.front().to_next = straight;
        add_strip(kind, pair_, Outlines::Side::joined, Outlines::Side::joined);
        strip.has_branch = is_branch = true;
      }
    }
    if (!has_strip) begin_strip(strips, piece, is_branch ? Outlines::Side::joined : begin_side_);
  }
  strips.column.clear();
  end_strips(kind);
}

void CutEvidence::join_column() {
  for (const Visibility::Kind kind : every_kind) {
    if (strips_[kind].count > 0 || !strips_[kind].column.empty()) join_column(kind);
  }
}

/// Ends the strips that do not go on in the current column.
void CutEvidence::end_strips(Visibility::Kind kind) {
  Strips& strips = strips_[kind];
  std::size_t kept = 0;
  for (std::size_t s = 0; s < strips.count; ++s) {
    Strip& strip = strips.open[s];
    if (!strip.goes_on) {
      add_strip(kind, strip.beams, strip.begin, strip.has_branch ? Outlines::Side::joined : end_side_);
      continue;
    }
    strip.newest = strip.next;
    if (kept != s) std::swap(strips.open[kept], strip);
    ++kept;
  }
  strips.count = kept;
}

/// The first column follows the last one, and ends what has come round to it.
void CutEvidence::close_circle() {
  begin_side_ = Outlines::Side::joined;
  end_side_ = Outlines::Side::other;
  lone_ = view_->links().lone_returns().data();
  find_column(0);
  join_column();
  for (const Visibility::Kind kind : every_kind) {
    Strips& strips = strips_[kind];
    for (std::size_t s = 0; s < strips.count; ++s) {
      Strip& strip = strips.open[s];
      if (strip.beams.size() > 1) add_strip(kind, strip.beams, strip.begin, Outlines::Side::joined);
    }
    strips.count = 0;
  }
}

void CutEvidence::find(const PlaneView& view, const PlaneTops& tops, HeightBand band, std::size_t lidar,
                       Visibility& visibility) {
  view_ = &view;
  tops_ = &tops;
  visibility_ = &visibility;
  lidar_ = lidar;
  band_ = band;
  const RingGrid& grid = view.grid();
  sign_ = view.sensor_above() >= 0 ? 1.0F : -1.0F;
  look_from(BeamEnd{0, 0, 0, 0});
  // Beyond all ranges.
  reach_ = 2 * (static_cast<float>(visibility.raster().grid().range_max) +
                std::sqrt(at_.x * at_.x + at_.y * at_.y));
  tilted_ = view.rotation().row(2).head<2>().norm() > level_enough;
  // Lidars turn clockwise as seen from above.
  clockwise_ = view.rotation()(2, 2) > 0;
  rings_ = grid.rings();
  step_ = sign_ > 0 ? 1 : -1;
  nearest_ring_ = sign_ > 0 ? 0 : rings_ - 1;
  marks_.resize(rings_);
  ends_.resize(rings_);
  beneath_.resize(rings_);
  crossings_.resize(rings_);
  // While the vehicle drives a whole turn lies between the last column and the first one.
  const bool closes = !grid.moved;
  begin_side_ = closes ? Outlines::Side::joined : Outlines::Side::unknown;

  lone_ = view.links().lone_returns().data();
  lone_end_ = lone_ + view.links().lone_returns().size();
  std::size_t silent = 0;
  for (std::size_t c = 0; c < grid.columns(); ++c) {
    silent = find_column(c) ? 0 : silent + 1;
    if (silent > 0 && silent <= most_silent) continue;
    const Outlines::Side side = silent > 0 ? Outlines::Side::unknown : Outlines::Side::other;
    end_side_ = side;
    join_column();
    begin_side_ = side;
  }
  if (closes) return close_circle();
  end_side_ = Outlines::Side::unknown;
  join_column();
}

}  // namespace lidard
