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
/// a row of steps outward, the source's cell that the step lies in and its distance from the source. Built
/// once per mounting, so that the walk along a beam is a row of look-ups.
class VisibilityTable {
 public:
  struct Step {
    std::uint16_t cell;
    std::uint16_t distance;  ///< units of the map
  };

  /// So many steps at once: the cells they lie in, and between which distances of the source.
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

  std::size_t steps() const { return middles_.size(); }
  /// Where step m begins, m from the origin; edge(steps()) is where the last one ends.
  float edge(std::size_t m) const { return edges_[m]; }
  /// The first step whose middle is not nearer than `range`.
  std::size_t step_at(float range) const;
  /// The number of steps that begin before `range`.
  std::size_t steps_to(float range) const;
  /// Steps stretch_steps * k and the following ones of a beam, and what they have in common. Those of beams
  /// side by side lie side by side: that is how they are looked at.
  const Step* steps(std::size_t beam, std::size_t source, std::size_t k) const {
    return steps_.data() + index(beam, source, k) * stretch_steps;
  }
  const Stretch& stretch(std::size_t beam, std::size_t source, std::size_t k) const {
    return stretches_[index(beam, source, k)];
  }
  const Step& step(std::size_t beam, std::size_t source, std::size_t m) const {
    return steps(beam, source, m / stretch_steps)[m % stretch_steps];
  }

 private:
  std::size_t index(std::size_t beam, std::size_t source, std::size_t k) const {
    return (source * stretches_of_beam_ + k) * beams_ + beam;
  }
  static Stretch stretch_of(const Step* steps, const FreeSpaceMap& map);

  std::vector<float> edges_;
  std::vector<std::uint32_t> steps_to_;  // for every shortest step, the steps that begin before its end
  std::vector<float> middles_;
  std::size_t sources_ = 0;
  std::size_t beams_;
  std::size_t stretches_of_beam_;
  std::vector<Step> steps_;
  std::vector<Stretch> stretches_;
};

}  // namespace lidard
