// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/evidence/free_space_map.h"
#include "core/evidence/raster.h"

namespace lidard {

/// Where the beams of an output scan lead through the views of the sources: for every beam, every source and
/// a row of steps outward, where the source sees the step begin. Built once per mounting, so that the walk
/// along a beam is a row of look-ups.
class VisibilityTable {
 public:
  using Place = FreeSpaceMap::Place;
  /// Where a way along a beam is looked at first in so many steps at once.
  static constexpr std::size_t steps_at_once = 8;

  /// Sets the steps for beams as long as `range_max`, m.
  explicit VisibilityTable(const Raster& raster);

  /// Fills in one of `sources` sources.
  void set(std::size_t source, std::size_t sources, const Raster& raster, const FreeSpaceMap& map);

  std::size_t steps() const { return edges_.size() - 1; }
  /// Where step m begins, m from the origin; edge(steps()) is where the last one ends.
  float edge(std::size_t m) const { return edges_[m]; }
  /// The step that holds `range`, m; of a border the outer one. steps(): beyond all of them.
  std::size_t step_at(float range) const;
  /// Where step m begins, and with m + 1 where it ends.
  Place place(std::size_t beam, std::size_t source, std::size_t m) const {
    return places_[index(beam, source, m)];
  }

 private:
  /// Places of beams side by side lie side by side: in that order they are used.
  std::size_t index(std::size_t beam, std::size_t source, std::size_t m) const {
    return (source * edges_.size() + m) * beams_ + beam;
  }

  std::vector<float> edges_;
  std::vector<std::uint32_t> step_at_;  // for every shortest step, the one that holds its begin
  std::size_t sources_ = 0;
  std::size_t beams_;
  std::vector<Place> places_;
};

}  // namespace lidard
