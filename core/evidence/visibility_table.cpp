// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/evidence/visibility_table.h"

#include <algorithm>
#include <cmath>

namespace lidard {
namespace {

// Length of the steps in which ways are compared; finer parts are compared where no single source sees a step
// completely.
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
  stretches_of_beam_ = steps() / stretch_steps + 1;
  // At most one step begins within a bucket of shortest_step.
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

VisibilityTable::Stretch VisibilityTable::stretch_of(const std::vector<Place>& places,
                                                     const FreeSpaceMap& map) {
  const auto count = static_cast<std::int32_t>(map.size());
  std::int32_t at = 0, low = 0, high = 0;  // cells from the first place
  std::uint16_t nearest = places[0].distance, farthest = places[0].distance;
  for (std::size_t m = 1; m < places.size(); ++m) {
    std::int32_t turn = places[m].cell - places[m - 1].cell;
    if (turn > count / 2) turn -= count;
    if (turn < -count / 2) turn += count;
    at += turn;
    low = std::min(low, at);
    high = std::max(high, at);
    nearest = std::min(nearest, places[m].distance);
    farthest = std::max(farthest, places[m].distance);
  }
  Stretch stretch{
      {}, FreeSpaceMap::ordered(nearest), static_cast<std::int16_t>(~FreeSpaceMap::ordered(farthest))};
  const std::int32_t first = places[0].cell + low;
  const std::int32_t span = high - low;
  const auto cell = static_cast<std::size_t>(first < 0 ? first + count : first);
  // A run that is too long is never free: no cell is free from distance 0 to 0.
  if (!map.find_run(cell, static_cast<std::size_t>(span) + 1, stretch.cells))
    stretch.nearest = FreeSpaceMap::ordered(0), stretch.not_farthest = FreeSpaceMap::ordered(0);
  return stretch;
}

void VisibilityTable::set(std::size_t source, std::size_t sources, const Raster& raster,
                          const FreeSpaceMap& map, const std::vector<float>& begins) {
  if (sources != sources_) {
    sources_ = sources;
    stretches_.assign(beams_ * sources * stretches_of_beam_, {});
    places_.assign(stretches_.size() * stretch_steps, {0, 0xFFFF});
    wedges_.assign((beams_ / wedge_beams + 1) * sources * stretches_of_beam_, {});
  }
  std::vector<Place> places(stretch_steps + 1);
  std::vector<std::vector<Place>> in_wedge(stretches_of_beam_);
  for (std::size_t beam = 0; beam < beams_; ++beam) {
    const float c = raster.cosine(beam), s = raster.sine(beam);
    // The range at which the beam passes the source, and the distance between them.
    const float passing = map.x() * c + map.y() * s;
    const std::int16_t passed = FreeSpaceMap::ordered(map.distance(std::fabs(map.y() * c - map.x() * s)));
    for (std::size_t k = 0; k < stretches_of_beam_; ++k) {
      for (std::size_t i = 0; i <= stretch_steps; ++i) {
        const float range = std::max(edges_[std::min(k * stretch_steps + i, steps())], nearest_place);
        const float from = std::max(range, begins[beam]);
        places[i] = map.place_of(from * c, from * s);
        if (i == stretch_steps) break;
        places_[index(beam, source, k) * stretch_steps + i] =
            from > range ? map.place_of(range * c, range * s) : places[i];
      }
      Stretch& stretch = stretches_[index(beam, source, k)];
      stretch = stretch_of(places, map);
      const float end = edges_[std::min((k + 1) * stretch_steps, steps())];
      if (passing > edges_[std::min(k * stretch_steps, steps())] && passing < end)
        stretch.nearest = std::min(stretch.nearest, passed);
      // Each beam is followed in the other direction than the beam before, so that all places are one path.
      Stretch& wedge = wedges_[(beam / wedge_beams * sources_ + source) * stretches_of_beam_ + k];
      if (beam % wedge_beams == 0) in_wedge[k].clear(), wedge.nearest = stretch.nearest;
      const std::int16_t nearest = std::min(wedge.nearest, stretch.nearest);
      if (beam % 2 != 0) std::reverse(places.begin(), places.end());
      in_wedge[k].insert(in_wedge[k].end(), places.begin(), places.end());
      if ((beam + 1) % wedge_beams == 0 || beam + 1 == beams_) wedge = stretch_of(in_wedge[k], map);
      wedge.nearest = std::min(wedge.nearest, nearest);
    }
  }
}

}  // namespace lidard
