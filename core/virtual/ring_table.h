// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "core/frames/cloud.h"

namespace lidard {

/// Where the beams of a multi-plane lidar point, learnt from its returns: the direction of a beam without
/// return is known from the others of its ring.
class RingTable {
 public:
  /// Forgets all when the number of rings changes.
  void set_rings(std::size_t rings);
  /// Takes a part of a cloud's returns (all of them the first time). `with_offsets`: its columns tell an
  /// azimuth, counted clockwise.
  void learn(const Cloud& cloud, bool with_offsets);

  bool is_known(std::size_t ring) const { return rings_[ring].count > 0; }
  /// rad above the sensor's x-y plane.
  double elevation(std::size_t ring) const { return rings_[ring].mean(rings_[ring].elevations); }
  /// rad by which the ring's beam is ahead of its column's azimuth.
  double offset(std::size_t ring) const { return rings_[ring].mean(rings_[ring].offsets); }

 private:
  struct Ring {
    double elevations = 0, offsets = 0;  // sums
    double count = 0;
    double mean(double sum) const { return count > 0 ? sum / count : 0; }
  };
  void take(const Cloud& cloud, std::size_t begin, std::size_t end, const CloudColumn* column);
  void fade();

  std::vector<Ring> rings_;
  std::size_t clouds_ = 0;
};

/// Where the rings of a cloud that does not number them lie: one elevation (rad) per ring, ascending. Empty
/// if the returns' elevations do not fall into groups.
void find_rings(const Cloud& cloud, std::vector<float>& elevations);

}  // namespace lidard
