// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/scan.h"
#include "drivers/sick/segment.h"

namespace lidard::sick {

/// The angular raster of a single-plane device: beam k points at `first + k * step`, rad. It spans a little
/// more than a turn, so that every segment finds its place before it is known which of them come.
struct SweepGrid {
  double first = 0;
  double step = 0;
  std::size_t beams = 0;

  double angle(std::size_t beam) const { return first + step * static_cast<double>(beam); }
  /// Nearest beam; may lie outside [0, beams).
  long nearest(double angle) const;
  /// The raster in which the beams of `line` lie; nothing where it has a single beam or turns clockwise.
  static std::optional<SweepGrid> of(const SegmentLine& line);
  /// True if the beams of `line` lie in this raster.
  bool holds(const SegmentLine& line) const;
};

/// The beams of one frame of a single-plane device, segment by segment.
class Sweep {
 public:
  /// Everything of it unobserved; allocates only when the raster or the number of echoes grows.
  void begin(const SweepGrid& grid, std::size_t echoes, float range_min, float range_max);
  /// Places the beams of a segment's line. `had_echo` (as long as the raster) remembers which beams ever had
  /// one. Returns how many beams lie a quarter step or more beside the raster.
  std::size_t add(const SegmentLine& line, std::vector<std::uint8_t>& had_echo);

  bool is_empty() const { return empty_; }
  /// Beams that were sent: [first_beam, end_beam).
  std::size_t first_beam() const { return first_beam_; }
  std::size_t end_beam() const { return end_beam_; }
  /// Length of the first and of the last segment, beams.
  std::size_t first_segment() const { return first_segment_; }
  std::size_t last_segment() const { return last_segment_; }
  /// Device time of a beam, us, by the times of the first and last segment; exact where it was sent.
  double time_us(std::size_t beam) const;
  /// Device time between neighbouring beams, us.
  double beam_us() const;
  std::uint64_t base_us() const { return base_us_; }
  /// Copies the beams [begin, begin + count) to `out`, whose geometry they become; with `echoes` of each.
  void copy(std::size_t begin, std::size_t count, std::size_t echoes, bool with_intensities,
            PlanarScan& out) const;
  bool reflector(std::size_t beam) const { return reflectors_[beam] != 0; }
  std::size_t reflectors() const { return reflector_count_; }
  const PlanarScan& beams() const { return beams_; }

 private:
  void put(const SegmentLine& line, std::size_t from, std::size_t beam);
  void note_extent(const SegmentLine& line, std::size_t begin, std::size_t end);

  SweepGrid grid_;
  PlanarScan beams_;
  std::vector<std::uint8_t> reflectors_;
  std::size_t reflector_count_ = 0;
  bool empty_ = true;
  std::size_t first_beam_ = 0, end_beam_ = 0, first_segment_ = 0, last_segment_ = 0;
  std::uint64_t base_us_ = 0;  // of the first segment's first beam
  double last_us_ = 0;         // of the last beam, after base_us_
};

}  // namespace lidard::sick
