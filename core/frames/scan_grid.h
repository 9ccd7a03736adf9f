// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

#include "core/base/angle.h"
#include "core/base/expected.h"
#include "core/frames/scan.h"

namespace lidard {

/// Encoding of evidence in a scan. `strict`: only what is proven. `safety`: every return, and free only what
/// is proven free. `flatten`: points alone, as ira_laser_tools has it.
enum class Profile : std::uint8_t { strict, safety, flatten };

/// Heights of the output frame that count, m; by default all.
struct HeightBand {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
};

/// Settings of a merged or virtual scan. Names and meaning as in ira_laser_tools; angles in rad, m, s.
struct ScanGridSpec {
  double angle_min = -pi_d;
  double angle_max = pi_d;
  std::optional<double> angle_increment;  ///< default: from `beams`
  std::optional<std::size_t> beams;       ///< beams of the whole span; default 1440 for a full circle
  double time_increment = 0;
  double scan_time = 0;  ///< 0: the period of the sources
  double range_min = 0;
  double range_max = 100;
};

/// The beams of an output scan. Angles are computed in double and stored in float, such that every consumer's
/// count rule holds: angle_max = angle_min + (beams - 1) * increment; a full circle has no repeated last
/// beam.
struct ScanGrid {
  double angle_min = 0;
  double increment = 0;
  std::size_t beams = 0;
  bool full_circle = false;
  double time_increment = 0;
  double scan_time = 0;
  double range_min = 0;
  double range_max = 0;

  /// The beam whose centre is nearest to `angle` (any finite rad); `beams` if the angle lies outside the
  /// span.
  std::size_t nearest(double angle) const;
  double angle(std::size_t beam) const { return angle_min + static_cast<double>(beam) * increment; }
  /// Sets geometry and limits of `scan` and makes every beam `invalid`.
  void prepare(PlanarScan& scan, bool with_intensities) const;
};

/// Builds the grid, or reports the fault of the specification and its remedy.
Expected<ScanGrid> make_grid(const ScanGridSpec& spec);

/// gmapping drops scans with this many beams or more (openslam_gmapping, LASER_MAXBEAMS).
constexpr std::size_t gmapping_beam_limit = 2048;

}  // namespace lidard
