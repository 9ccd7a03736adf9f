// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/virtual/cut_evidence.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/angle.h"
#include "core/base/bytes.h"

namespace lidard {
namespace {

constexpr float infinite = std::numeric_limits<float>::infinity();
// A plane that leans more than that (sine) shows the beams of one column in different directions.
constexpr float level_enough = 0.02F;
// Pieces so near to each other are one, m and share of the distance: neighbouring columns cross in turn.
constexpr float touching = 0.05F;
constexpr float touching_share = 0.02F;
// Neighbouring columns share their border, so that no cell between them is left out.
constexpr float overlap = 1.05F;

}  // namespace

void CutEvidence::mark_beams() {
  const std::size_t cells = view_->heights().size();
  resize_amply(cells, marks_);
  const Beam* const kinds = view_->grid().kind.data();
  const float* const heights = view_->heights().data();
  const float level = view_->level();
  const bool from_above = sign_ > 0;
  std::uint8_t* const marks = marks_.data();
  for (std::size_t i = 0; i < cells; ++i) {
    const int ends = (kinds[i] == Beam::point ? known : 0) | (kinds[i] == Beam::none ? known : 0);
    const int beneath = heights[i] < level ? 1 : 0;
    const int over = heights[i] > level ? 1 : 0;
    marks[i] = static_cast<std::uint8_t>(ends | (crosses * (ends & (from_above ? beneath : over))));
  }
}

inline CutEvidence::Ray CutEvidence::ray(std::size_t i) const {
  const BeamEnd e = ends_[i];
  const float x = axes_[0] * e.x + axes_[1] * e.y + axes_[2] * e.z;
  const float y = axes_[3] * e.x + axes_[4] * e.y + axes_[5] * e.z;
  const float end = std::sqrt(x * x + y * y);
  return {x, y, end, end * sensor_ / std::max(sensor_ - sign_ * view_->above(i), 1e-6F)};
}

inline void CutEvidence::add(const Ray& first, const Ray& seen_along, float to) {
  const float begin = tilted_ ? (fast_atan2(first.y, first.x) + static_cast<float>(pi_d)) * per_rad_ : 0;
  wedges_.push_back({first.at, std::min(to, farthest_), blind_, seen_along.x, seen_along.y, begin});
  blind_ = 0;
}

/// A column whose beams do not look in one direction needs it by itself.
void CutEvidence::add_blind(const Ray& lowest) {
  blind_ = lowest.at;
  add(lowest, lowest, -1);
}

/// The cells whose middle lies within half a column of `azimuth`.
CutEvidence::Cells CutEvidence::cells_at(float azimuth) const {
  const float half = width_ * overlap / 2;
  const float middle = azimuth + static_cast<float>(cells_.size());
  return {static_cast<std::size_t>(middle - half + 0.5F), static_cast<std::size_t>(middle + half - 0.5F)};
}

void CutEvidence::claim(Cells cells, float from, float to) {
  if (!(to >= from)) return;
  for (std::size_t k = cells.first; k <= cells.last; ++k) claim(cell(k), from, to);
}

void CutEvidence::claim(Cell& cell, float from, float to) const {
  auto& free = cell.free;
  if (!free[0].exists()) {
    free[0] = {from, to};
    return;
  }
  const float slack = touching + touching_share * to;
  bool taken = false;
  for (Piece& piece : free) {
    if (piece.exists() && (from > piece.to + slack || to < piece.from - slack)) continue;
    piece = piece.exists() ? Piece{std::min(piece.from, from), std::max(piece.to, to)} : Piece{from, to};
    taken = true;
    break;
  }
  if (taken && free[1].exists() && free[1].from <= free[0].to + slack && free[1].to >= free[0].from - slack)
    free = {Piece{std::min(free[0].from, free[1].from), std::max(free[0].to, free[1].to)}, Piece{}};
}

void CutEvidence::take_wedges() {
  const std::size_t n = wedges_.size();
  for (auto* list : {&x_, &y_, &azimuths_}) list->resize(n);
  float* const x = x_.data();
  float* const y = y_.data();
  float* const azimuths = azimuths_.data();
  for (std::size_t i = 0; i < n; ++i) x[i] = wedges_[i].x, y[i] = wedges_[i].y;
  const float per_rad = per_rad_;
  for (std::size_t i = 0; i < n; ++i)
    azimuths[i] = (fast_atan2(y[i], x[i]) + static_cast<float>(pi_d)) * per_rad;
  for (std::size_t i = 0; i < n; ++i) {
    const Wedge& wedge = wedges_[i];
    const Cells cells = cells_at(azimuths[i]);
    if (wedge.blind > 0) {
      for (std::size_t k = cells.first; k <= cells.last; ++k) cell(k).blind = wedge.blind;
    }
    if (tilted_ && wedge.to >= 0)
      take_tilted(wedge, azimuths[i]);
    else
      claim(cells, wedge.from, wedge.to);
  }
}

/// Between its beams the piece leads through several directions.
void CutEvidence::take_tilted(const Wedge& wedge, float azimuth) {
  const auto turn = static_cast<float>(cells_.size());
  const float length = wedge.to - wedge.from;
  float span = azimuth - wedge.begin;
  span -= turn * std::round(span / turn);
  const float parts = std::max(1.0F, std::ceil(std::fabs(span)));
  for (float part = 0; part < parts; ++part) {
    float at = wedge.begin + span * (part + 0.5F) / parts;
    at -= at >= turn ? turn : 0;
    claim(cells_at(at < 0 ? at + turn : at), wedge.from + length * part / parts,
          wedge.from + length * (part + 1) / parts);
  }
}

/// m to the nearest thing of a column that stands between the heights of the band.
float CutEvidence::wall_in_band(std::size_t column) const {
  if (!(band_.max > band_.min)) return infinite;
  const RingGrid& grid = view_->grid();
  float nearest = infinite;
  for (std::size_t r = 0; r < grid.rings(); ++r) {
    const std::size_t i = grid.index(column, r);
    if (grid.kind[i] != Beam::point || view_->ground().is_ground[i] != 0) continue;
    const auto height = static_cast<double>(view_->heights()[i]);
    if (!(height >= band_.min && height <= band_.max)) continue;
    const Raster::Point at = view_->place(grid.ends[i]);
    nearest = std::min(nearest, std::hypot(at.x - view_->translation().x(), at.y - view_->translation().y()));
  }
  return nearest;
}

/// What the crossing beam `before` meets beyond the plane may stand in the plane too, under its neighbour.
/// The ground does not, nor what is known to be lower.
bool CutEvidence::is_hidden(std::size_t before, std::size_t upper) const {
  if (view_->grid().kind[before] != Beam::point || view_->ground().is_ground[before] != 0) return false;
  return tops_->verdicts()[upper] != PlaneTops::stays_below;
}

void CutEvidence::find_wedges(std::size_t column) {
  const std::size_t base = view_->grid().index(column, 0);
  const std::uint8_t* const marks = marks_.data();
  farthest_ = wall_in_band(column);
  const auto mark = [&](std::size_t k) { return marks[beam(base, k)]; };
  std::size_t k = 0;
  while (k < rings_ && mark(k) == 0) ++k;
  if (k == rings_) return;
  const std::size_t lowest = beam(base, k);
  const bool in_line = (mark(k) & crosses) != 0 && !tilted_ && view_->grid().fired_in_columns();
  if (!in_line && sign_ * view_->above(lowest) < sensor_) add_blind(ray(lowest));
  for (bool nearest = in_line;; nearest = false) {
    while (k < rings_ && (mark(k) & crosses) == 0) ++k;
    if (k == rings_) return;
    Ray first = ray(beam(base, k++));
    if (nearest) blind_ = first.at;
    for (; k < rings_ && (mark(k) & crosses) != 0; ++k) {
      if (!tilted_) continue;
      const Ray next = ray(beam(base, k));
      add(first, next, next.at);
      first = next;
    }
    const std::size_t last = beam(base, k - 1);
    end_wedge(first, last, k < rings_ && mark(k) != 0 ? beam(base, k) : last);
  }
}

/// `next`: the neighbour of the last beam that crosses; `last` itself if nothing is known of it.
void CutEvidence::end_wedge(const Ray& first, std::size_t last, std::size_t next) {
  const Ray seen_along = ray(next);
  if (next == last) {
    add(first, seen_along, seen_along.at);
  } else if (!is_hidden(last, next)) {
    add(first, seen_along, seen_along.end);
  } else {
    const Ray before = ray(last);
    add(first, seen_along, std::max(before.at, std::min(before.end, seen_along.end)));
  }
}

/// Columns do not lie quite evenly, so that a cell between two of them may have been left out.
void CutEvidence::fill_holes() {
  const std::size_t n = cells_.size();
  for (std::size_t k = 0; k < n; ++k) {
    if (cells_[k].free[0].exists()) continue;
    const Cell& a = cells_[k > 0 ? k - 1 : n - 1];
    const Cell& b = cells_[k + 1 < n ? k + 1 : 0];
    if (cells_[k].blind <= 0) cells_[k].blind = std::min(a.blind, b.blind);
    if (!a.free[0].exists() || !b.free[0].exists()) continue;
    const Piece both{std::max(a.free[0].from, b.free[0].from), std::min(a.free[0].to, b.free[0].to)};
    if (both.exists()) cells_[k].free[0] = both;
  }
}

void CutEvidence::find(const PlaneView& view, const PlaneTops& tops, HeightBand band,
                       const std::array<FreeSpaceMap*, pieces>& free, FreeSpaceMap& blind) {
  view_ = &view;
  tops_ = &tops;
  band_ = band;
  sign_ = view.sensor_above() >= 0 ? 1.0F : -1.0F;
  sensor_ = std::fabs(view.sensor_above());
  tilted_ = view.rotation().row(2).head<2>().norm() > level_enough;
  cells_.assign(blind.size(), {});
  per_rad_ = static_cast<float>(static_cast<double>(cells_.size()) / (two_pi));
  width_ = static_cast<float>(view.grid().step()) * per_rad_;
  mark_beams();
  wedges_.clear();
  rings_ = view.grid().rings();
  ends_ = view.grid().ends.data();
  const Eigen::Matrix3f& r = view.rotation();
  axes_ = {r(0, 0), r(0, 1), r(0, 2), r(1, 0), r(1, 1), r(1, 2)};
  for (std::size_t c = 0; c < view.grid().columns(); ++c) find_wedges(c);
  take_wedges();
  fill_holes();
  for (std::size_t k = 0; k < cells_.size(); ++k) {
    for (std::size_t p = 0; p < pieces; ++p) {
      if (cells_[k].free[p].exists()) free[p]->claim(k, cells_[k].free[p].from, cells_[k].free[p].to);
    }
    if (cells_[k].blind > 0) blind.claim(k, 0, cells_[k].blind);
  }
}

}  // namespace lidard
