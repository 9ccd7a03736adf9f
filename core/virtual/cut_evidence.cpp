// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/virtual/cut_evidence.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/angle.h"
#include "core/base/bytes.h"
#include "core/base/clones.h"

namespace lidard {
namespace {

constexpr float infinite = std::numeric_limits<float>::infinity();
// sine; in a plane that leans more, the beams of one column have different directions.
constexpr float level_enough = 0.02F;
// Pieces within this gap (m and share of the distance) are joined: neighbouring columns cross at alternating
// distances.
constexpr float touching = 0.05F;
constexpr float touching_share = 0.02F;
// Columns are widened by this factor, so that no cell between two columns is left out.
constexpr float overlap = 1.05F;
// Wedges are claimed in blocks of about this number, which stay in the cache.
constexpr std::size_t block = 512;

}  // namespace

LIDARD_CLONES void CutEvidence::mark_beams() {
  const std::size_t cells = view_->heights().size();
  resize_amply(cells, own_marks_, marks_);
  const Beam* const kinds = view_->grid().kind.data();
  const float* const heights = view_->heights().data();
  const char* const grounds = view_->ground().is_ground.data();
  const float level = view_->level();
  const bool from_above = sign_ > 0;
  std::uint8_t* const own = own_marks_.data();
  for (std::size_t i = 0; i < cells; ++i) {
    const int point = kinds[i] == Beam::point ? 1 : 0;
    const int ends = point | (kinds[i] == Beam::none ? 1 : 0);
    const int beyond = from_above ? (heights[i] < level ? 1 : 0) : (heights[i] > level ? 1 : 0);
    const int thing = point & (grounds[i] == Ground::sure ? 0 : 1);
    own[i] = static_cast<std::uint8_t>(known * ends | crosses * (ends & beyond) | meets * (thing & beyond));
  }
  std::uint8_t* const marks = marks_.data();
  const std::size_t column = rings_;
  if (cells < 2 * column) {
    marks_ = own_marks_;
    return;
  }
  mark_agreed(own, own + cells - column, own + column, marks, column);
  mark_agreed(own + column, own, own + 2 * column, marks + column, cells - 2 * column);
  mark_agreed(own + cells - column, own + cells - 2 * column, own, marks + cells - column, column);
}

LIDARD_CLONES void CutEvidence::mark_agreed(const std::uint8_t* own, const std::uint8_t* before,
                                            const std::uint8_t* after, std::uint8_t* marks,
                                            std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    const int blocked = (before[i] & ~(before[i] >> 1) & known) | (after[i] & ~(after[i] >> 1) & known);
    const int met = (before[i] | after[i]) & meets & (own[i] << 1);
    marks[i] = static_cast<std::uint8_t>((own[i] | met) & ~(blocked * (crosses | meets)));
  }
}

std::array<std::size_t, 3> CutEvidence::abreast(std::size_t i) const {
  const std::size_t cells = own_marks_.size();
  return {i, i >= rings_ ? i - rings_ : i + cells - rings_,
          i + rings_ < cells ? i + rings_ : i + rings_ - cells};
}

bool CutEvidence::on_one_surface(std::size_t i, std::size_t beside) const {
  const std::size_t first = beside + rings_ == i || beside > i + rings_ ? beside : i;
  return i == beside || view_->links().level_at(first);
}

CutEvidence::End CutEvidence::end_abreast(std::size_t i) const {
  const auto ends = [this](std::size_t beam) { return (own_marks_[beam] & (known | crosses)) == known; };
  End nearest{infinite, false};
  for (const std::size_t beam : abreast(i)) {
    const bool same = on_one_surface(i, beam);
    // On one surface every column sees as far as its own return.
    if (!ends(beam) || (same && beam != i && ends(i))) continue;
    const float end = end_of(beam) * (same ? 1 : 1 - corner_);
    if (end < nearest.at) nearest = {end, view_->grid().kind[beam] == Beam::point};
  }
  return nearest;
}

inline CutEvidence::End CutEvidence::thing_abreast(std::size_t last) const {
  End nearest{infinite, true};
  if ((marks_[last] & meets) == 0) return nearest;
  const bool met = (own_marks_[last] & meets) != 0;
  for (const std::size_t beam : abreast(last)) {
    const bool same = on_one_surface(last, beam);
    if ((own_marks_[beam] & meets) == 0 || (same && beam != last && met)) continue;
    if (is_hidden(beam, static_cast<std::size_t>(static_cast<std::ptrdiff_t>(beam) + step_)))
      nearest.at = std::min(nearest.at, end_of(beam) * (same ? 1 : 1 - corner_));
  }
  return nearest;
}

inline CutEvidence::Ray CutEvidence::ray(std::size_t i) const {
  return {i, end_of(i) * sensor_ / std::max(sensor_ - sign_ * view_->above(i), 1e-6F)};
}

inline void CutEvidence::add(const Ray& first, const Ray& seen_along, End end) {
  const float from = std::max(first.at, looked_from_);
  const Piece free = end.at > farthest_ ? Piece{from, farthest_, true} : Piece{from, end.at, end.hides};
  const auto nearest = static_cast<std::uint32_t>(first.beam),
             along = static_cast<std::uint32_t>(seen_along.beam);
  if (free.exists()) free_.push_back({free, nearest, along});
  if (blind_.to > 0) blinds_.push_back({blind_, nearest, along});
  blind_ = {};
}

/// Adds the blind part of a column whose lowest beams do not cross the plane or have different directions.
void CutEvidence::add_blind(std::size_t lowest) {
  const Ray along = ray(lowest);
  const End end = end_abreast(lowest);
  blind_ = end.at < along.at && end.hides ? Piece{0, end.at, true}
                                          : Piece{0, std::max(along.at, looked_from_), false};
  add(along, along, {-1, false});
}

/// The cells whose middle lies within half a column of `azimuth`.
CutEvidence::Cells CutEvidence::cells_at(float azimuth) const {
  const float half = width_ * overlap / 2;
  const float middle = azimuth + static_cast<float>(cells_.size());
  const auto index = [](float at) { return static_cast<std::size_t>(static_cast<std::int32_t>(at)); };
  return {index(middle - half + 0.5F), index(middle + half - 0.5F)};
}

void CutEvidence::claim(Cells cells, const Piece& piece) {
  if (!piece.exists()) return;
  for (std::size_t k = cells.first; k <= cells.last; ++k) claim(cell(k), piece);
}

void CutEvidence::claim(Cell& cell, const Piece& piece) const {
  const auto both = [](const Piece& a, const Piece& b) {
    return Piece{std::min(a.from, b.from), std::max(a.to, b.to), a.is_shorter(b) ? b.hides : a.hides};
  };
  auto& free = cell.free;
  if (!free[0].exists()) {
    free[0] = piece;
    return;
  }
  // What hides the end of a piece stands in the gap behind it.
  const auto is_apart = [](const Piece& near, const Piece& far) {
    return far.from > near.to + (near.hides ? 0 : touching + touching_share * near.to);
  };
  bool joined = false;
  for (Piece& old : free) {
    if (old.exists() && (is_apart(old, piece) || is_apart(piece, old))) continue;
    old = old.exists() ? both(old, piece) : piece;
    joined = true;
    break;
  }
  if (joined && free[1].exists() && !is_apart(free[0], free[1]) && !is_apart(free[1], free[0]))
    free = {both(free[0], free[1]), Piece{}};
}

LIDARD_CLONES void CutEvidence::find_azimuths(const std::vector<Wedge>& wedges, std::uint32_t Wedge::*beam,
                                              std::vector<float>& azimuths) {
  const std::size_t n = wedges.size();
  for (auto* list : {&x_, &y_, &azimuths}) list->resize(n);
  float* const x = x_.data();
  float* const y = y_.data();
  float* const to = azimuths.data();
  for (std::size_t i = 0; i < n; ++i) {
    const BeamEnd e = ends_[wedges[i].*beam];
    x[i] = axes_[0] * e.x + axes_[1] * e.y + axes_[2] * e.z;
    y[i] = axes_[3] * e.x + axes_[4] * e.y + axes_[5] * e.z;
  }
  const float per_rad = per_rad_;
  for (std::size_t i = 0; i < n; ++i) to[i] = (fast_atan2(y[i], x[i]) + static_cast<float>(pi_d)) * per_rad;
}

template <class Use>
void CutEvidence::each_cell(const std::vector<Wedge>& wedges, Use use) {
  find_azimuths(wedges, &Wedge::along, azimuths_);
  for (std::size_t i = 0; i < wedges.size(); ++i) {
    const Cells cells = cells_at(azimuths_[i]);
    for (std::size_t k = cells.first; k <= cells.last; ++k) use(cell(k), wedges[i].piece);
  }
}

void CutEvidence::claim_wedges() {
  each_cell(overs_, [](Cell& at, const Piece& piece) {
    Piece& old = at.over;
    const bool apart = old.exists() && (piece.from > old.to || piece.to < old.from);
    if (!old.exists() || (apart && piece.from < old.from))
      old = piece;
    else if (!apart)
      old = {std::min(old.from, piece.from), std::max(old.to, piece.to), false};
  });
  each_cell(blinds_, [](Cell& at, const Piece& piece) {
    if (at.blind.to <= 0 || piece.is_shorter(at.blind)) at.blind = piece;
  });
  if (tilted_) {
    find_azimuths(free_, &Wedge::along, azimuths_);
    find_azimuths(free_, &Wedge::first, begins_);
    for (std::size_t i = 0; i < free_.size(); ++i) claim_tilted(free_[i].piece, begins_[i], azimuths_[i]);
  } else {
    each_cell(free_, [this](Cell& at, const Piece& piece) { claim(at, piece); });
  }
  for (auto* list : {&free_, &blinds_, &overs_}) list->clear();
}

/// While the vehicle drove the beams began in different places, and what one column met may stand in the way
/// of another one's.
void CutEvidence::end_at_things() {
  each_cell(things_, [](Cell& at, const Piece& thing) {
    for (Piece& free : at.free) {
      if (free.exists() && free.from <= thing.to && free.to > thing.to) free = {free.from, thing.to, true};
    }
  });
  things_.clear();
}

/// Claims a piece that spans several directions, part by part.
void CutEvidence::claim_tilted(const Piece& piece, float begin, float azimuth) {
  const auto turn = static_cast<float>(cells_.size());
  const float length = piece.to - piece.from;
  float span = azimuth - begin;
  span -= turn * std::round(span / turn);
  const float parts = std::max(1.0F, std::ceil(std::fabs(span)));
  for (float part = 0; part < parts; ++part) {
    float at = begin + span * (part + 0.5F) / parts;
    at -= at >= turn ? turn : 0;
    claim(cells_at(at < 0 ? at + turn : at),
          {piece.from + length * part / parts, piece.from + length * (part + 1) / parts,
           piece.hides && part + 1 == parts});
  }
}

/// m to the nearest object of a column between the heights of the band.
float CutEvidence::wall_in_band(std::size_t column) const {
  if (!(band_.max > band_.min)) return infinite;
  const RingGrid& grid = view_->grid();
  float nearest = infinite;
  for (std::size_t r = 0; r < grid.rings(); ++r) {
    const std::size_t i = grid.index(column, r);
    if (grid.kind[i] != Beam::point || view_->ground().is_ground[i] == Ground::sure) continue;
    const auto height = static_cast<double>(view_->heights()[i]);
    if (!(height >= band_.min && height <= band_.max)) continue;
    nearest = std::min(nearest, end_of(i));
  }
  return nearest;
}

/// m from where on a column's beams have looked at all of the band: nearer its upper limit is above the
/// topmost beam of a lidar that stands in the band.
float CutEvidence::whole_band_from(std::size_t column) const {
  const float sensor = view_->level() + view_->sensor_above();
  const auto top = static_cast<float>(band_.max), bottom = static_cast<float>(band_.min);
  if (!(bottom < sensor && sensor < top && std::isfinite(top))) return 0;
  for (std::size_t r = rings_; r-- > 0;) {
    const std::size_t i = view_->grid().index(column, r);
    if ((own_marks_[i] & known) == 0) continue;
    const float rise = view_->heights()[i] - sensor;
    return rise > 0 ? end_of(i) * (top - sensor) / rise : infinite;
  }
  return infinite;
}

/// True if the object that the crossing beam `before` hits beyond the plane may reach the plane under the
/// neighbouring beam. The ground does not, nor does an object that is known to be lower.
bool CutEvidence::is_hidden(std::size_t before, std::size_t upper) const {
  if (view_->grid().kind[before] != Beam::point || view_->ground().is_ground[before] == Ground::sure)
    return false;
  return tops_->verdicts()[upper] != PlaneTops::stays_below;
}

void CutEvidence::find_wedges(std::size_t column) {
  const std::size_t base = view_->grid().index(column, 0);
  const std::uint8_t* const marks = marks_.data();
  farthest_ = wall_in_band(column);
  looked_from_ = whole_band_from(column);
  const auto mark = [&](std::size_t k) { return marks[beam(base, k)]; };
  const auto thing_before = [&](std::size_t next, std::size_t last) {
    return next < rings_ ? thing_abreast(last) : End{infinite, true};
  };
  std::size_t k = 0;
  while (k < rings_ && mark(k) == 0) ++k;
  if (k == rings_) return;
  const std::size_t lowest = beam(base, k);
  const bool in_line = (mark(k) & crosses) != 0 && !tilted_ && view_->grid().fired_in_columns();
  if (!in_line && sign_ * view_->above(lowest) < sensor_) add_blind(lowest);
  for (bool nearest = in_line;; nearest = false) {
    while (k < rings_ && (mark(k) & crosses) == 0) ++k;
    if (k == rings_) return;
    Ray first = ray(beam(base, k));
    if (nearest) blind_ = {0, std::max(first.at, looked_from_), false};
    std::size_t last = beam(base, k++);
    End thing = thing_before(k, last);
    for (; k < rings_ && (mark(k) & crosses) != 0; last = beam(base, k++), thing = thing_before(k, last)) {
      if (thing.at < infinite) break;
      if (!tilted_) continue;
      const Ray next = ray(beam(base, k));
      add(first, next, {next.at, false});
      first = next;
    }
    end_wedge(first, last, k < rings_ && mark(k) != 0 ? beam(base, k) : last, thing);
  }
}

/// `next`: the neighbour of the last crossing beam, or `last` itself if nothing is known of the neighbour.
void CutEvidence::end_wedge(const Ray& first, std::size_t last, std::size_t next, End thing) {
  const Ray seen_along = ray(next);
  if (next == last) {
    add(first, seen_along, {seen_along.at, false});
    return;
  }
  const bool crosses_too = (marks_[next] & crosses) != 0;
  const End end = crosses_too ? End{seen_along.at, false} : end_abreast(next);
  const bool ended = thing.at < end.at;
  const End free_end = ended ? End{std::max(ray(last).at, thing.at), true} : end;
  add(first, seen_along, free_end);
  if (view_->grid().moved && free_end.hides)
    things_.push_back({{0, free_end.at, true}, 0, static_cast<std::uint32_t>(ended ? last : next)});
  const std::uint8_t top = tops_->verdicts()[next];
  const float from = std::min(free_end.at, farthest_);
  if (crosses_too && ended && from <= end.at && (top == PlaneTops::none || top == PlaneTops::likely_below))
    overs_.push_back({{from, end.at, false}, 0, static_cast<std::uint32_t>(next)});
}

/// Fills cells that were left out between unevenly spaced columns.
void CutEvidence::fill_holes() {
  const std::size_t n = cells_.size();
  for (std::size_t k = 0; k < n; ++k) {
    if (cells_[k].free[0].exists()) continue;
    const Cell& a = cells_[k > 0 ? k - 1 : n - 1];
    const Cell& b = cells_[k + 1 < n ? k + 1 : 0];
    if (cells_[k].blind.to <= 0) cells_[k].blind = a.blind.is_shorter(b.blind) ? a.blind : b.blind;
    if (!a.free[0].exists() || !b.free[0].exists()) continue;
    Piece both = a.free[0].is_shorter(b.free[0]) ? a.free[0] : b.free[0];
    both.from = std::max(a.free[0].from, b.free[0].from);
    if (both.exists()) cells_[k].free[0] = both;
  }
}

void CutEvidence::find(const PlaneView& view, const PlaneTops& tops, HeightBand band,
                       const std::array<FreeSpaceMap*, pieces>& free, FreeSpaceMap& blind,
                       FreeSpaceMap& over) {
  view_ = &view;
  tops_ = &tops;
  band_ = band;
  sign_ = view.sensor_above() >= 0 ? 1.0F : -1.0F;
  sensor_ = std::fabs(view.sensor_above());
  tilted_ = view.rotation().row(2).head<2>().norm() > level_enough;
  cells_.assign(blind.size(), {});
  per_rad_ = static_cast<float>(static_cast<double>(cells_.size()) / (two_pi));
  width_ = static_cast<float>(view.grid().step()) * per_rad_;
  rings_ = view.grid().rings();
  step_ = sign_ > 0 ? 1 : -1;
  nearest_ring_ = sign_ > 0 ? 0 : rings_ - 1;
  corner_ = std::min(0.2F, 2 * static_cast<float>(view.grid().step()));
  mark_beams();
  ends_ = view.grid().ends.data();
  const Eigen::Matrix3f& r = view.rotation();
  axes_ = {r(0, 0), r(0, 1), r(0, 2), r(1, 0), r(1, 1), r(1, 2)};
  for (std::size_t c = 0; c < view.grid().columns(); ++c) {
    find_wedges(c);
    if (free_.size() + blinds_.size() >= block || c + 1 == view.grid().columns()) claim_wedges();
  }
  fill_holes();
  end_at_things();
  for (std::size_t k = 0; k < cells_.size(); ++k) {
    for (std::size_t p = 0; p < pieces; ++p) {
      // A way from a cell with two pieces to one with one must stay within one map to be free.
      const Piece& piece = cells_[k].free[p].exists() ? cells_[k].free[p] : cells_[k].free[0];
      if (piece.exists()) free[p]->claim(k, piece.from, piece.to, piece.hides);
    }
    const Piece& unseen = cells_[k].blind;
    const Piece& nearest = cells_[k].free[0];
    const Piece& last = nearest.from <= unseen.to && nearest.to > unseen.to ? nearest : unseen;
    if (unseen.to > 0) blind.claim(k, 0, last.to, last.hides);
    if (cells_[k].over.exists()) over.claim(k, cells_[k].over.from, cells_[k].over.to);
  }
}

}  // namespace lidard
