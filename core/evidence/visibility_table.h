// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
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

  /// So many steps at once: the cells they lead through, and between which distances of the source.
  struct Stretch {
    FreeSpaceMap::RunAt cells;
    std::int16_t nearest;       ///< ordered() as in FreeSpaceMap::Run
    std::int16_t not_farthest;  ///< turned over
    bool is_free(const FreeSpaceMap::Run* runs) const {
      const FreeSpaceMap::Run a = runs[cells.first];
      const FreeSpaceMap::Run b = runs[cells.second];
      return std::max(a.from, b.from) <= nearest && std::max(a.not_to, b.not_to) <= not_farthest;
    }
  };
  static constexpr std::size_t stretch_steps = 8;

  /// Sets the steps for beams that are looked along as far as `range_max`, m.
  explicit VisibilityTable(const Raster& raster);

  /// Fills in one of `sources` sources.
  void set(std::size_t source, std::size_t sources, const Raster& raster, const FreeSpaceMap& map);

  std::size_t steps() const { return edges_.size() - 1; }
  /// Where step m begins, m from the origin; edge(steps()) is where the last one ends.
  float edge(std::size_t m) const { return edges_[m]; }
  /// The step that holds `range`, m; of a border the outer one. steps(): beyond all of them.
  std::size_t step_at(float range) const;
  /// Steps stretch_steps * k and the following ones of a beam. Those of beams side by side lie side by side:
  /// that is how they are looked at.
  const Stretch& stretch(std::size_t beam, std::size_t source, std::size_t k) const {
    return stretches_[index(beam, source, k)];
  }
  /// Where step m begins, and with m + 1 where it ends.
  Place place(std::size_t beam, std::size_t source, std::size_t m) const {
    return places_[index(beam, source, m / stretch_steps) * stretch_steps + m % stretch_steps];
  }

 private:
  std::size_t index(std::size_t beam, std::size_t source, std::size_t k) const {
    return (source * stretches_of_beam_ + k) * beams_ + beam;
  }
  static Stretch stretch_of(const std::vector<Place>& places, const FreeSpaceMap& map);

  std::vector<float> edges_;
  std::vector<std::uint32_t> step_at_;  // for every shortest step, the one that holds its begin
  std::size_t sources_ = 0;
  std::size_t beams_;
  std::size_t stretches_of_beam_;
  std::vector<Place> places_;
  std::vector<Stretch> stretches_;
};

}  // namespace lidard
