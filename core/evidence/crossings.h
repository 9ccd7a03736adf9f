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
    float at;              ///< m from the origin
    std::uint32_t edge;    ///< in Outlines::edges
    std::uint16_t source;  ///< that of the edge
    std::int8_t free;      ///< change of the number of free layers on the way outward
    std::int8_t hidden;    ///< the same of hidden layers
  };
  /// The crossings of one beam within all ranges, by distance.
  struct Range {
    const Crossing* first;
    const Crossing* last;
    const Crossing* begin() const { return first; }
    const Crossing* end() const { return last; }
  };

  /// Layers of free and of hidden space.
  struct Layers {
    std::int16_t free = 0, hidden = 0;
  };

  /// Finds the crossings of all beams with the outlines of so many sources.
  void find(const Outlines& outlines, const Raster& raster, std::size_t sources);
  /// The layers of every source at the origin. Outlines are closed, so these are the layers that all edges
  /// together lead out of.
  const Layers* at_origin(std::size_t beam) const { return at_origin_.data() + beam * sources_; }
  Range of(std::size_t beam) const {
    return {crossings_.data() + ends_[beam], crossings_.data() + ends_[beam + 1]};
  }

 private:
  void find_beams(const Outlines& outlines, const Raster& raster);
  void count(const Outlines& outlines, const Raster& raster);
  void cross(const Outlines& outlines, std::uint32_t edge, std::uint32_t first, std::uint32_t end,
             bool clockwise, const Raster& raster);
  static void sort(Crossing* first, Crossing* last);
  template <class Use>
  void each_stretch(const Outlines::Edge& edge, const Raster& raster, Use use) const;

  std::vector<float> positions_;      // of the vertices, in beams
  std::vector<std::uint32_t> beams_;  // rounded up, at most the number of beams
  std::vector<std::uint32_t> ends_;   // in crossings_: the end of the crossings of the beam before
  std::vector<Crossing> crossings_;
  std::size_t sources_ = 0;
  std::vector<Layers> at_origin_;  // by beam and source
};

}  // namespace lidard
