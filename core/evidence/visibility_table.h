// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/evidence/free_space_map.h"
#include "core/evidence/raster.h"

namespace lidard {

/// Where the beams of an output scan pass through the maps of the sources: for every beam, source and step
/// outward, the place of the step's begin. The table is built once per mounting, so that a walk along a beam
/// only reads it.
class VisibilityTable {
 public:
  using Place = FreeSpaceMap::Place;

  /// A number of steps together: the cells and the distances from the source that they pass through.
  struct Stretch {
    FreeSpaceMap::RunAt cells;
    std::int16_t nearest;       ///< ordered() as in FreeSpaceMap::Run
    std::int16_t not_farthest;  ///< inverted
    bool is_free(const FreeSpaceMap::Run* runs) const {
      const FreeSpaceMap::Run a = runs[cells.first];
      const FreeSpaceMap::Run b = runs[cells.second];
      return std::max(a.from, b.from) <= nearest && std::max(a.not_to, b.not_to) <= not_farthest;
    }
  };
  static constexpr std::size_t stretch_steps = 8;
  /// m from the origin to the first place of a way: a source in the origin sees the origin itself in no
  /// direction.
  static constexpr float nearest_place = 0.001F;
  /// A wedge is so many neighbouring beams together; the last one may have fewer.
  static constexpr std::size_t wedge_beams = 8;

  /// Computes the steps up to the range_max of the raster's grid.
  explicit VisibilityTable(const Raster& raster);

  /// Fills in source number `source` of `sources`. Stretches leave out what lies before `begins`, m of each
  /// beam.
  void set(std::size_t source, std::size_t sources, const Raster& raster, const FreeSpaceMap& map,
           const std::vector<float>& begins);

  std::size_t steps() const { return edges_.size() - 1; }
  /// Where step m begins, m from the origin; edge(steps()) is where the last one ends.
  float edge(std::size_t m) const { return edges_[m]; }
  /// The step that holds `range`, m; at a border the outer one. steps(): beyond the last step.
  std::size_t step_at(float range) const;
  /// The steps of a beam from stretch_steps * k on. Neighbouring beams are neighbours in memory, in the order
  /// of access.
  const Stretch& stretch(std::size_t beam, std::size_t source, std::size_t k) const {
    return stretches_[index(beam, source, k)];
  }
  /// The steps of all beams of a wedge from stretch_steps * k on: free if this is free.
  const Stretch& wedge(std::size_t wedge, std::size_t source, std::size_t k) const {
    return wedges_[(wedge * sources_ + source) * stretches_of_beam_ + k];
  }
  std::size_t stretches() const { return stretches_of_beam_; }
  /// Where step m begins; the next step begins where it ends.
  Place place(std::size_t beam, std::size_t source, std::size_t m) const {
    return places_[index(beam, source, m / stretch_steps) * stretch_steps + m % stretch_steps];
  }

 private:
  std::size_t index(std::size_t beam, std::size_t source, std::size_t k) const {
    return (source * stretches_of_beam_ + k) * beams_ + beam;
  }
  static Stretch stretch_of(const std::vector<Place>& places, const FreeSpaceMap& map);

  std::vector<float> edges_;
  std::vector<std::uint32_t> step_at_;  // per shortest_step of range: the step that holds its begin
  std::size_t sources_ = 0;
  std::size_t beams_;
  std::size_t stretches_of_beam_;
  std::vector<Place> places_;
  std::vector<Stretch> stretches_;
  std::vector<Stretch> wedges_;
};

}  // namespace lidard
