// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/evidence/visibility_table.h"

#include <algorithm>
#include <cmath>

namespace lidard {
namespace {

// Ways are compared in so long steps, and exactly where no source sees a step as a whole.
constexpr double shortest_step = 0.12;  // m
constexpr double growth = 0.025;        // of the range

}  // namespace

VisibilityTable::VisibilityTable(const Raster& raster) : beams_(raster.grid().beams) {
  double at = 0;
  while (at < raster.grid().range_max) {
    edges_.push_back(static_cast<float>(at));
    at += std::max(shortest_step, growth * at);
  }
  edges_.push_back(static_cast<float>(at));
  // No two steps begin within a shortest one.
  for (std::size_t k = 0; static_cast<double>(k) * shortest_step <= at; ++k) {
    const auto begin = static_cast<float>(static_cast<double>(k) * shortest_step);
    const auto next = std::upper_bound(edges_.begin(), edges_.end(), begin) - edges_.begin();
    step_at_.push_back(static_cast<std::uint32_t>(std::max<std::ptrdiff_t>(next - 1, 0)));
  }
}

std::size_t VisibilityTable::step_at(float range) const {
  if (!(range > 0)) return 0;
  const auto bucket = static_cast<std::size_t>(range * static_cast<float>(1 / shortest_step));
  if (bucket >= step_at_.size()) return steps();
  std::size_t step = step_at_[bucket];
  while (step < steps() && edges_[step + 1] <= range) ++step;
  return step;
}

void VisibilityTable::set(std::size_t source, std::size_t sources, const Raster& raster,
                          const FreeSpaceMap& map) {
  if (sources != sources_) {
    sources_ = sources;
    places_.assign(beams_ * sources * edges_.size(), {0, 0xFFFF});
  }
  for (std::size_t m = 0; m < edges_.size(); ++m) {
    for (std::size_t beam = 0; beam < beams_; ++beam)
      places_[index(beam, source, m)] = map.place_of(edges_[m] * raster.cosine(beam), edges_[m] * raster.sine(beam));
  }
}

}  // namespace lidard
