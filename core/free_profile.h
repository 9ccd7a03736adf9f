// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/sweep.h"

namespace lidard {

/// How far one source sees in each direction around itself, as integers that a walk along the output's beams
/// can compare quickly. A cell is a part of a beam's width; the cell after the last one is everything outside
/// the field of view, where nothing is free.
class FreeProfile {
 public:
  struct Cell {
    std::uint16_t from = 0xFFFF;  ///< units
    std::uint16_t span = 0;
    bool is_free(std::uint16_t distance) const { return static_cast<std::uint16_t>(distance - from) <= span; }
  };

  /// Sets the cells for a source; `unit` is the length of one step of distance, m.
  void set(const BeamRays& rays, double unit);
  /// Takes the evidence of a sweep: linked returns are interpolated, else the nearest beam counts.
  void fill(const Sweep& sweep);
  /// No evidence at all.
  void clear();

  /// The cell in direction (dx, dy) of the output frame from the source.
  std::uint16_t cell_towards(const BeamRays& rays, float dx, float dy) const;
  std::uint16_t distance(float meters) const {
    const float units = meters * per_meter_;
    return units < 65534.0F ? static_cast<std::uint16_t>(units + 0.5F) : std::uint16_t{65534};
  }
  const Cell* cells() const { return cells_.data(); }
  std::size_t size() const { return cells_.size(); }

 private:
  Cell cell_of(float from, float to) const;

  std::size_t beams_ = 0;
  std::size_t per_beam_ = 1;
  float per_meter_ = 1;
  std::vector<Cell> cells_;
};

}  // namespace lidard
