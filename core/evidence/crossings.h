// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/evidence/outline.h"
#include "core/evidence/raster.h"

namespace lidard {

/// Where the beams of an output cross the edges of outlines.
///
///       a                  The azimuth of a vertex, in beams, is computed once and rounded up once: beams
///      / `.                4, 5, 6 cross the edge from a (4) to b (7) counter-clockwise. Neighbouring
///   --/----`.--- 6         edges share their vertex, so a closed outline has as many crossings in one
///    /       `.            direction as in the other, and no beam slips through between two edges.
///   o------ 5  b
class Crossings {
 public:
  struct Crossing {
    float at;            ///< m from the origin
    std::uint32_t edge;  ///< in Outlines::edges
    bool clockwise;      ///< the beam goes from right to left
  };
  /// The crossings of one beam, by distance.
  struct Range {
    const Crossing* first;
    const Crossing* last;
    const Crossing* begin() const { return first; }
    const Crossing* end() const { return last; }
  };

  /// Finds the crossings of all beams.
  void find(const Outlines& outlines, const Raster& raster);
  Range of(std::size_t beam) const {
    return {sorted_.data() + firsts_[beam], sorted_.data() + firsts_[beam + 1]};
  }

 private:
  struct Found {
    Crossing crossing;
    std::uint32_t beam;
  };
  void find_beams(const Outlines& outlines, const Raster& raster);
  void cross(const Outlines& outlines, std::uint32_t edge, std::int32_t first, std::int32_t end,
             bool clockwise, const Raster& raster);
  void sort(std::size_t beams);

  std::vector<float> positions_;     // of the vertices, in beams
  std::vector<std::int32_t> beams_;  // rounded up, at most the number of beams
  std::vector<Found> found_;
  std::vector<std::uint32_t> firsts_;  // in sorted_, per beam, and the end
  std::vector<Crossing> sorted_;
};

}  // namespace lidard
