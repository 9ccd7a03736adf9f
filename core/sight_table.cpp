// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/sight_table.h"

#include <algorithm>

namespace lidard {
namespace {

// Half of the longest way that may go unseen (0.3 m or 5 % of the range), or finer.
constexpr double shortest_step = 0.12;  // m
constexpr double growth = 0.025;        // of the range

}  // namespace

SightTable::SightTable(const Raster& raster) {
  double at = 0;
  while (at < raster.grid().range_max) {
    const double step = std::max(shortest_step, growth * at);
    edges_.push_back(static_cast<float>(at));
    middles_.push_back(static_cast<float>(at + step / 2));
    at += step;
  }
  edges_.push_back(static_cast<float>(at));
}

std::size_t SightTable::step_at(float range) const {
  return static_cast<std::size_t>(std::lower_bound(middles_.begin(), middles_.end(), range) -
                                  middles_.begin());
}

std::size_t SightTable::steps_to(float range) const {
  const auto end = std::lower_bound(edges_.begin(), edges_.end(), range);
  return std::min(static_cast<std::size_t>(end - edges_.begin()), middles_.size());
}

void SightTable::set(std::size_t source, std::size_t sources, const Raster& raster,
                     const FreeProfile& profile) {
  if (sources != sources_) {
    sources_ = sources;
    steps_.assign(raster.grid().beams * sources * middles_.size(), {0, 0xFFFF});
  }
  for (std::size_t beam = 0; beam < raster.grid().beams; ++beam) {
    Step* row = steps_.data() + (beam * sources_ + source) * middles_.size();
    for (const float range : middles_) {
      const float dx = range * raster.cosine(beam) - profile.x();
      const float dy = range * raster.sine(beam) - profile.y();
      *row++ = {profile.cell_towards(dx, dy), profile.distance(std::sqrt(dx * dx + dy * dy))};
    }
  }
}

}  // namespace lidard
