// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/evidence/visibility_table.h"

#include <algorithm>

namespace lidard {
namespace {

// Half of the longest way that may go unseen (0.3 m or 5 % of the range), or finer.
constexpr double shortest_step = 0.12;  // m
constexpr double growth = 0.025;        // of the range

}  // namespace

VisibilityTable::VisibilityTable(const Raster& raster) : beams_(raster.grid().beams) {
  double at = 0;
  while (at < raster.grid().range_max) {
    const double step = std::max(shortest_step, growth * at);
    edges_.push_back(static_cast<float>(at));
    middles_.push_back(static_cast<float>(at + step / 2));
    at += step;
  }
  edges_.push_back(static_cast<float>(at));
  stretches_of_beam_ = (middles_.size() + stretch_steps - 1) / stretch_steps;
  // No two steps begin within a shortest one.
  for (std::size_t k = 0; at > 0 && static_cast<double>(k) * shortest_step <= at; ++k) {
    const auto end = static_cast<float>(static_cast<double>(k + 1) * shortest_step);
    const auto steps = std::lower_bound(edges_.begin(), edges_.end(), end) - edges_.begin();
    steps_to_.push_back(static_cast<std::uint32_t>(steps));
  }
}

std::size_t VisibilityTable::step_at(float range) const {
  return static_cast<std::size_t>(std::lower_bound(middles_.begin(), middles_.end(), range) -
                                  middles_.begin());
}

std::size_t VisibilityTable::steps_to(float range) const {
  if (!(range > 0)) return 0;
  const auto bucket = static_cast<std::size_t>(range * static_cast<float>(1 / shortest_step));
  if (bucket >= steps_to_.size()) return middles_.size();
  std::size_t steps = std::min<std::size_t>(steps_to_[bucket] + 1, middles_.size());
  while (steps > 0 && edges_[steps - 1] >= range) --steps;
  return steps;
}

VisibilityTable::Stretch VisibilityTable::stretch_of(const Step* steps, const FreeSpaceMap& map) {
  const auto count = static_cast<std::int32_t>(map.size());
  std::int32_t at = 0, low = 0, high = 0;  // cells from the first step's
  std::uint16_t nearest = steps[0].distance, farthest = steps[0].distance;
  for (std::size_t m = 1; m < stretch_steps; ++m) {
    std::int32_t turn = steps[m].cell - steps[m - 1].cell;
    if (turn > count / 2) turn -= count;
    if (turn < -count / 2) turn += count;
    at += turn;
    low = std::min(low, at);
    high = std::max(high, at);
    nearest = std::min(nearest, steps[m].distance);
    farthest = std::max(farthest, steps[m].distance);
  }
  Stretch stretch{
      {}, FreeSpaceMap::ordered(nearest), static_cast<std::int16_t>(~FreeSpaceMap::ordered(farthest))};
  const std::int32_t first = steps[0].cell + low;
  const auto cell = static_cast<std::size_t>(first < 0 ? first + count : first);
  // Nothing is free from before the source.
  if (!map.find_run(cell, static_cast<std::size_t>(high - low + 1), stretch.cells))
    stretch.nearest = FreeSpaceMap::ordered(0), stretch.not_farthest = FreeSpaceMap::ordered(0);
  return stretch;
}

void VisibilityTable::set(std::size_t source, std::size_t sources, const Raster& raster,
                          const FreeSpaceMap& map) {
  if (sources != sources_) {
    sources_ = sources;
    stretches_.assign(beams_ * sources * stretches_of_beam_, {});
    steps_.assign(stretches_.size() * stretch_steps, {0, 0xFFFF});
  }
  for (std::size_t beam = 0; beam < beams_; ++beam) {
    for (std::size_t k = 0; k < stretches_of_beam_; ++k) {
      Step* const steps = steps_.data() + index(beam, source, k) * stretch_steps;
      for (std::size_t i = 0; i < stretch_steps; ++i) {
        const float range = middles_[std::min(k * stretch_steps + i, middles_.size() - 1)];
        const float dx = range * raster.cosine(beam) - map.x();
        const float dy = range * raster.sine(beam) - map.y();
        steps[i] = {map.cell_towards(dx, dy), map.distance(std::sqrt(dx * dx + dy * dy))};
      }
      stretches_[index(beam, source, k)] = stretch_of(steps, map);
    }
  }
}

}  // namespace lidard
