// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/virtual/plane_view.h"

namespace lidard {

/// Judges what lies between two neighbouring rings of which the upper one passes over what the lower one
/// meets, and whether that concerns a plane.
///
///    S (sensor)                 With level distances d and heights h above the plane, the upper beam passes
///     \ `-._                    over what the lower one meets at
///      \    `-._ passing            passing = h_S + (h_up - h_S) d_low / d_up.
///    ===\=======`-._======      The plane (===), at h = 0, lies at -top above the highest return (top); the
///        x top      `-._        thing reaches it if
///    ____|______________`x_         -top < (passing - top) / 3.
///
/// The top of a thing is at least as high as its highest return and lower than the lowest beam that passes
/// over it; both are taken over all neighbouring columns that see the thing, for tops are mostly level. Where
/// the plane is close to the return, the thing reaches it; where it is close to the beam, the thing does not.
class PlaneTops {
 public:
  /// Of a beam and the one below it. `hides`: what the upper beam meets may go down to the plane behind what
  /// the lower one meets.
  enum Verdict : std::uint8_t { none = 0, reaches = 1, stays_below = 2, hides = 3 };

  void find(const PlaneView& view);
  /// By RingGrid::index() of the upper beam.
  const std::vector<std::uint8_t>& verdicts() const { return verdicts_; }

 private:
  /// Neighbouring columns in which a ring meets one thing.
  struct Run {
    std::size_t first = 0, end = 0;  // columns [first, end)
    float top = 0;                   // m above the plane, the highest return
    float passing = 0;               // m above the plane, the lowest beam that passes over it
    float nearest = 0;               // m from the sensor
  };
  void mark_steps(const PlaneView& view);
  void take(const PlaneView& view, std::size_t column, std::size_t upper);
  void close(const PlaneView& view, std::size_t ring);
  bool is_flat(const PlaneView& view, std::size_t ring, const Run& run) const;

  std::vector<std::uint8_t> verdicts_;
  std::vector<std::uint8_t> steps_;  // the upper beam passes over what the lower one meets
  std::vector<Run> runs_;            // the newest one of each upper ring
};

}  // namespace lidard
