// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/cut_evidence.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/angle.h"

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

/// Calls `take` for each of `cells` cells, all around, whose middle lies within `half` of `azimuth`.
template <class Cells, class Take>
void each_cell(Cells& cells, float azimuth, float half, Take take) {
  const std::size_t count = cells.size();
  // A turn ahead, so that nothing is negative and rounding down is cutting off.
  const float middle = azimuth + static_cast<float>(count);
  const auto last = static_cast<std::size_t>(middle + half - 0.5F);
  for (auto k = static_cast<std::size_t>(middle - half + 0.5F); k <= last; ++k)
    take(cells[k >= 2 * count ? k - 2 * count : k >= count ? k - count : k]);
}

bool has_end(Beam kind) { return kind == Beam::point || kind == Beam::none; }

}  // namespace

CutEvidence::Ray CutEvidence::ray(std::size_t i) const {
  const RingGrid& g = *grid_;
  const Eigen::Matrix3f& r = cut_->rotation();
  const float x = r(0, 0) * g.x[i] + r(0, 1) * g.y[i] + r(0, 2) * g.z[i];
  const float y = r(1, 0) * g.x[i] + r(1, 1) * g.y[i] + r(1, 2) * g.z[i];
  const float end = std::sqrt(x * x + y * y);
  const float share = sensor_ / std::max(sensor_ - above(i), 1e-6F);
  return {end * share, end, x, y};
}

float CutEvidence::azimuth(const Ray& ray) const {
  return (fast_atan2(ray.y, ray.x) + static_cast<float>(pi_d)) * per_rad_;
}

void CutEvidence::claim(float azimuth, float from, float to) {
  to = std::min(to, farthest_);
  if (!(to >= from)) return;
  const float slack = touching + touching_share * to;
  each_cell(cells_, azimuth, width_ * overlap / 2, [&](Cell& cell) {
    auto& free = cell.free;
    bool taken = false;
    for (Piece& piece : free) {
      if (piece.exists() && (from > piece.to + slack || to < piece.from - slack)) continue;
      piece = piece.exists() ? Piece{std::min(piece.from, from), std::max(piece.to, to)} : Piece{from, to};
      taken = true;
      break;
    }
    if (taken && free[1].exists() && free[1].from <= free[0].to + slack && free[1].to >= free[0].from - slack)
      free = {Piece{std::min(free[0].from, free[1].from), std::max(free[0].to, free[1].to)}, Piece{}};
  });
}

void CutEvidence::take_wedge(const Ray& a, const Ray& b, float end) {
  if (!tilted_) {
    claim(azimuth(b), a.at, end);
    return;
  }
  const auto turn = static_cast<float>(cells_.size());
  const float begin = azimuth(a);
  float span = azimuth(b) - begin;
  span -= turn * std::round(span / turn);
  const float parts = std::max(1.0F, std::ceil(std::fabs(span)));
  for (float part = 0; part < parts; ++part) {
    const float from = a.at + (end - a.at) * part / parts;
    const float to = a.at + (end - a.at) * (part + 1) / parts;
    float at = begin + span * (part + 0.5F) / parts;
    at -= at >= turn ? turn : 0;
    claim(at < 0 ? at + turn : at, from, to);
  }
}

void CutEvidence::take_blind(const Ray& lowest) {
  each_cell(cells_, azimuth(lowest), width_ * overlap / 2, [&](Cell& cell) { cell.blind = lowest.at; });
}

/// m to the nearest thing of a column that stands between the heights of the band.
float CutEvidence::wall_in_band(std::size_t column) const {
  if (!(band_.max > band_.min)) return infinite;
  float nearest = infinite;
  for (std::size_t r = 0; r < grid_->rings(); ++r) {
    const std::size_t i = grid_->index(column, r);
    if (grid_->kind[i] != Beam::point || ground_->is_ground[i] != 0) continue;
    const auto height = static_cast<double>(cut_->heights()[i]);
    if (height >= band_.min && height <= band_.max) nearest = std::min(nearest, ray(i).end);
  }
  return nearest;
}

void CutEvidence::take_column(std::size_t column) {
  const std::size_t rings = grid_->rings();
  const std::size_t base = grid_->index(column, 0);
  farthest_ = wall_in_band(column);
  bool any = false;
  bool open = false;
  std::size_t before = 0;  // the beam that crossed last
  Ray first{};             // of the piece at hand; its last crossing where the plane leans
  for (std::size_t k = 0; k < rings; ++k) {
    const std::size_t i = base + (sign_ > 0 ? k : rings - 1 - k);
    const bool known = has_end(grid_->kind[i]);
    const bool crosses = known && above(i) < 0;
    if (crosses && !open) first = ray(i);
    if (known && !any && above(i) < sensor_) take_blind(crosses ? first : ray(i));
    any |= known;
    if (crosses && open && tilted_) {
      const Ray next = ray(i);
      take_wedge(first, next, next.at);
      first = next;
    }
    if (open && !crosses) {
      const Ray last = ray(before);
      if (!known) {
        take_wedge(first, last, last.at);
      } else {
        // What stands between both beams hides the rest; the ground does not.
        const Ray next = ray(i);
        const bool hidden = grid_->kind[before] == Beam::point && ground_->is_ground[before] == 0;
        take_wedge(first, next, hidden ? std::max(last.at, std::min(last.end, next.end)) : next.end);
      }
    }
    open = crosses;
    before = i;
  }
  if (open) {
    const Ray last = ray(before);
    take_wedge(first, last, last.at);
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

void CutEvidence::find(const RingGrid& grid, const Ground& ground, const PlaneCut& cut, float level,
                       HeightBand band, const std::array<FreeProfile*, pieces>& free, FreeProfile& blind) {
  grid_ = &grid;
  ground_ = &ground;
  cut_ = &cut;
  level_ = level;
  band_ = band;
  sign_ = cut.translation().z() >= level ? 1.0F : -1.0F;
  sensor_ = std::fabs(cut.translation().z() - level);
  tilted_ = cut.rotation().row(2).head<2>().norm() > level_enough;
  cells_.assign(blind.size(), {});
  per_rad_ = static_cast<float>(static_cast<double>(cells_.size()) / (2 * pi_d));
  width_ = static_cast<float>(grid.step()) * per_rad_;
  for (std::size_t c = 0; c < grid.columns(); ++c) take_column(c);
  fill_holes();
  for (std::size_t k = 0; k < cells_.size(); ++k) {
    for (std::size_t p = 0; p < pieces; ++p) {
      if (cells_[k].free[p].exists()) free[p]->claim(k, cells_[k].free[p].from, cells_[k].free[p].to);
    }
    if (cells_[k].blind > 0) blind.claim(k, 0, cells_[k].blind);
  }
}

}  // namespace lidard
