// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/merge/cross_check.h"

#include <algorithm>
#include <cmath>

namespace lidard {
namespace {

constexpr double least_margin = 0.1;  // m
constexpr double margin_in_sigmas = 5;

}  // namespace

CrossCheck::CrossCheck(const MergeOptions& options, std::size_t sources, double range_max, double noise)
    : options_(options),
      unit_(FreeSpaceMap::unit_for(range_max)),
      margin_(static_cast<float>(std::max(least_margin, margin_in_sigmas * noise))),
      sources_(sources) {}

void CrossCheck::set_source(std::size_t index, const BeamRays& rays) {
  Source& source = sources_[index];
  source.map.set_source(rays, unit_);
  source.two_beams = static_cast<float>(2 * std::abs(rays.increment));
}

bool CrossCheck::sees_through(const Source& source, float x, float y) const {
  const float dx = x - source.map.x();
  const float dy = y - source.map.y();
  const float away = std::sqrt(dx * dx + dy * dy);
  const std::uint16_t here = source.map.distance(away);
  const std::uint16_t behind = source.map.distance(away + margin_);
  for (const float side : {0.0F, -source.two_beams, source.two_beams}) {
    const auto& cell = source.map.cells()[source.map.cell_towards(dx - side * dy, dy + side * dx)];
    if (!cell.is_free(here) || !cell.is_free(behind)) return false;
  }
  return true;
}

void CrossCheck::unlink(std::size_t beam, PlacedScan& sweep) {
  sweep.linked[beam] = 0;
  if (beam > 0) sweep.linked[beam - 1] = 0;
}

void CrossCheck::check_source(std::size_t index, const std::vector<const PlacedScan*>& sweeps,
                              const std::vector<Stamp>& ends) {
  PlacedScan& checked = sources_[index].checked;
  for (std::size_t beam = 0; beam < checked.kind.size(); ++beam) {
    if (checked.kind[beam] == Return::nothing) continue;
    bool seen_through = false;
    bool outdated = false;
    for (std::size_t s = 0; s < sources_.size(); ++s) {
      if (s == index || sweeps[s] == nullptr) continue;
      if (!sees_through(sources_[s], checked.x[beam], checked.y[beam])) continue;
      seen_through = true;
      outdated = outdated || ends[s] > ends[index];
    }
    if (options_.newest_wins && outdated) {
      checked.kind[beam] = Return::nothing;
      ++conflicts_;
    } else if (options_.veil_cross_check && seen_through && checked.kind[beam] == Return::surface) {
      checked.kind[beam] = Return::doubtful;
      ++veils_;
    } else {
      continue;
    }
    unlink(beam, checked);
  }
  const auto cut = [&](const PlacedScan::Corner& corner) { return checked.linked[corner.beam] == 0; };
  checked.corners.erase(std::remove_if(checked.corners.begin(), checked.corners.end(), cut),
                        checked.corners.end());
}

void CrossCheck::check(std::vector<const PlacedScan*>& sweeps, const std::vector<Stamp>& ends) {
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    if (sweeps[s] != nullptr) sources_[s].map.fill(*sweeps[s]);
  }
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    if (sweeps[s] == nullptr) continue;
    sources_[s].checked = *sweeps[s];
    check_source(s, sweeps, ends);
  }
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    if (sweeps[s] != nullptr) sweeps[s] = &sources_[s].checked;
  }
}

}  // namespace lidard
