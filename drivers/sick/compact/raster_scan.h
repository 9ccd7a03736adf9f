// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/frames/scan.h"
#include "drivers/sick/compact/compact_telegram.h"

namespace lidard::sick {

/// The angular raster of a single-plane device: beam k points at `first + k * step`, rad. It spans a little
/// more than a turn, so that every segment fits before the set of segments is known.
struct RasterGrid {
  double first = 0;
  double step = 0;
  std::size_t beams = 0;

  double angle(std::size_t beam) const { return first + step * static_cast<double>(beam); }
  /// Nearest beam; may lie outside [0, beams).
  long nearest(double angle) const;
  /// The raster in which the beams of `line` lie; nothing for a single beam or a clockwise line.
  static std::optional<RasterGrid> of(const SegmentLine& line);
  /// Moves the raster to the announced angles of `line`, whose beams it holds. They are rounded (float), each
  /// segment's in its own way.
  void align(const SegmentLine& line);
  /// True if the beams of `line` lie in this raster.
  bool holds(const SegmentLine& line) const;
};

/// When the beams of a frame were measured, us of the device's clock.
struct RasterTimes {
  double first_us = 0;  ///< the first beam, after RasterScan::base_us()
  double beam_us = 0;   ///< from beam to beam
};

/// The beams of one frame of a single-plane device, segment by segment.
class RasterScan {
 public:
  /// So many scans after its last echo a beam counts as one that the device may have hidden since.
  static constexpr std::uint8_t echo_memory = 50;
  /// Starts with all beams unobserved; allocates only when the raster or the number of echoes grows.
  void begin(const RasterGrid& grid, std::size_t echoes, float range_min, float range_max);
  /// Adds the beams of a segment's line and sets `had_echo` (as long as the raster) of beams with an echo
  /// to echo_memory. Returns the number of beams that lie a quarter step or more beside the raster.
  std::size_t add(const SegmentLine& line, std::vector<std::uint8_t>& had_echo);

  /// The raster, aligned with the first segment by angle.
  const RasterGrid& grid() const { return grid_; }
  bool is_empty() const { return empty_; }
  /// The received beams are [first_beam, end_beam).
  std::size_t first_beam() const { return first_beam_; }
  std::size_t end_beam() const { return end_beam_; }
  /// Length of the first and of the last segment, beams.
  std::size_t first_segment() const { return first_segment_; }
  std::size_t last_segment() const { return last_segment_; }
  /// Number of segments.
  std::size_t segments() const { return begin_count_; }
  /// The times of the beams from the start times of the segments. `known_beam_us` is from an earlier frame
  /// (0: unknown), for a frame of one segment.
  RasterTimes times(double known_beam_us) const;
  /// Start time of the first segment, us.
  std::uint64_t base_us() const { return begins_[0].us; }
  /// Copies the beams [begin, begin + count) with `echoes` echoes to `out`, all but their angles.
  void copy(std::size_t begin, std::size_t count, std::size_t echoes, bool with_intensities,
            PlanarScan& out) const;
  /// The last echo of a beam that hit a reflector; range 0: it did not.
  struct Reflector {
    float range = 0;      // m
    float intensity = 0;  // 0: not sent
  };
  const Reflector& reflector(std::size_t beam) const { return reflectors_[beam]; }
  std::size_t reflectors() const { return reflector_count_; }

 private:
  void put(const SegmentLine& line, std::size_t from, std::size_t beam);
  void put_reflector(const SegmentLine& line, std::size_t from, Reflector& reflector);
  void note_extent(const SegmentLine& line, std::size_t begin, std::size_t end);
  void note_begin(std::size_t beam, std::uint64_t us);

  /// Where and when a segment begins.
  struct Begin {
    std::size_t beam;
    std::uint64_t us;
  };

  RasterGrid grid_;
  PlanarScan beams_;
  std::vector<Reflector> reflectors_;
  std::size_t reflector_count_ = 0;
  bool empty_ = true;
  std::size_t first_beam_ = 0, end_beam_ = 0, first_segment_ = 0, last_segment_ = 0;
  std::array<Begin, max_segments> begins_{};  // by angle
  std::size_t begin_count_ = 0;
  double inside_us_ = 0;  // from the first to the last beam of the newest segment
};

}  // namespace lidard::sick
