// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/free_profile.h"

#include <algorithm>
#include <cmath>

#include "core/angle.h"

namespace lidard {
namespace {

// Between two returns of a slanting wall the free way changes; so fine it is followed.
constexpr double cell_width = 0.2 * pi_d / 180;
constexpr std::size_t most_cells = 65000;

}  // namespace

void FreeProfile::set(const BeamRays& rays, double unit) {
  beams_ = rays.size();
  per_meter_ = static_cast<float>(1 / unit);
  const double wanted = std::ceil(std::abs(rays.increment) / cell_width - 1e-3);
  per_beam_ = std::max<std::size_t>(1, static_cast<std::size_t>(wanted));
  per_beam_ = std::max<std::size_t>(1, std::min(per_beam_, most_cells / std::max<std::size_t>(beams_, 1)));
  cells_.assign(beams_ * per_beam_ + 1, {});
}

void FreeProfile::clear() { std::fill(cells_.begin(), cells_.end(), Cell{}); }

FreeProfile::Cell FreeProfile::cell_of(float from, float to) const {
  const float first = std::ceil(from * per_meter_);
  const float last = std::min(to * per_meter_, 65533.0F);
  if (!(to > 0) || last < first) return {};
  return {static_cast<std::uint16_t>(first), static_cast<std::uint16_t>(last - first)};
}

void FreeProfile::fill(const Sweep& sweep) {
  const auto parts = static_cast<float>(per_beam_);
  const std::size_t half = per_beam_ / 2;
  for (std::size_t beam = 0; beam < beams_; ++beam) {
    const Cell own = cell_of(sweep.free_from[beam], sweep.free_to[beam]);
    Cell* const cells = cells_.data() + beam * per_beam_;
    for (std::size_t part = 0; part < per_beam_; ++part) {
      // Middle of the cell, in beams from this beam's direction.
      const float off = (static_cast<float>(part) + 0.5F) / parts - 0.5F;
      const bool after = part > half || (part == half && per_beam_ % 2 == 0);
      const std::size_t other = after ? beam + 1 : beam - 1;
      const bool linked = after ? sweep.linked[beam] != 0 : beam > 0 && sweep.linked[beam - 1] != 0;
      if (!linked || off == 0) {
        cells[part] = own;
        continue;
      }
      const float share = std::fabs(off);
      const float a = sweep.free_to[beam];
      const float b = sweep.free_to[other];
      // On a straight line the inverse of the distance changes (nearly) evenly.
      cells[part] = cell_of(sweep.free_from[beam], a * b / (b + share * (a - b)));
    }
  }
  if (!cells_.empty()) cells_.back() = {};
}

std::uint16_t FreeProfile::cell_towards(const BeamRays& rays, float dx, float dy) const {
  const float beam = rays.beam_towards(dx, dy);
  const auto last = static_cast<std::uint16_t>(cells_.size() - 1);
  if (beam < -0.5F) return last;
  const auto cell = static_cast<std::size_t>((beam + 0.5F) * static_cast<float>(per_beam_));
  return cell < last ? static_cast<std::uint16_t>(cell) : last;
}

}  // namespace lidard
