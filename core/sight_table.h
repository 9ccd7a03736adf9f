// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/free_profile.h"
#include "core/raster.h"

namespace lidard {

/// Where the beams of an output scan lead through the views of the sources: for every beam, every source and
/// a row of steps outward, the source's cell that the step lies in and its distance from the source. Built
/// once per mounting, so that the walk along a beam is a row of look-ups.
class SightTable {
 public:
  struct Step {
    std::uint16_t cell;
    std::uint16_t distance;  ///< units of the profile
  };

  /// Sets the steps for beams that are looked along as far as `range_max`, m.
  explicit SightTable(const Raster& raster);

  /// Fills in one of `sources` sources.
  void set(std::size_t source, std::size_t sources, const Raster& raster, const FreeProfile& profile);

  std::size_t steps() const { return middles_.size(); }
  /// Where step m begins, m from the origin; edge(steps()) is where the last one ends.
  float edge(std::size_t m) const { return edges_[m]; }
  /// The first step whose middle is not nearer than `range`.
  std::size_t step_at(float range) const;
  /// The number of steps that begin before `range`.
  std::size_t steps_to(float range) const;
  const Step* row(std::size_t beam, std::size_t source) const {
    return steps_.data() + (beam * sources_ + source) * middles_.size();
  }

 private:
  std::vector<float> edges_;
  std::vector<float> middles_;
  std::size_t sources_ = 0;
  std::vector<Step> steps_;
};

}  // namespace lidard
