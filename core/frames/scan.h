// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/base/angle.h"
#include "core/base/time.h"

namespace lidard {

/// Neighbouring beams of a scan.
struct BeamWindow {
  std::size_t first = 0;
  std::size_t count = 0;
  /// Those of the `count` beams that are not wanted: a sector behind a scanner holds the two ends of its
  /// scan. The scan keeps the order in which they were measured, and its size.
  std::size_t gap_first = 0, gap_count = 0;
};

/// Which of `beams` beams, the first at `angle` and each `step` further (rad), lie in a sector. Limits are
/// rounded where they come from: a beam on one of them is inside.
BeamWindow beams_inside(const Sector& sector, double angle, double step, std::size_t beams);

/// State of a beam. `none`: observed, nothing there. `near`: something too close to measure. `invalid`: not
/// observed, or the device does not vouch for the value.
enum class BeamStatus : std::uint8_t { hit, none, near, invalid };

const char* to_string(BeamStatus status);

/// The range that REP 117 prescribes for a beam without a measurement: +inf, -inf or NaN.
float range_without_hit(BeamStatus status);

/// How the beams of a scanner deviate from even angles: a mirror that turns unevenly. The beam of the even
/// angle a points at a + amplitude * sin(a + phase); rad.
struct AngleWave {
  double amplitude = 0, phase = 0;

  double bent(double even) const { return amplitude == 0 ? even : even + amplitude * std::sin(even + phase); }
  friend bool operator==(const AngleWave& a, const AngleWave& b) {
    return a.amplitude == b.amplitude && a.phase == b.phase;
  }
};

/// One sweep of a single-plane scanner (or a merged or virtual scan), in its own frame: x ahead, angles in
/// rad counter-clockwise from x (REP 103).
///
/// Invariants, tested by `violation()`: beam i points at the even angle angle_min + i * angle_increment, bent
/// by `wave`; angle_max is the even angle of the last beam, computed in float; stamp is the first ray's time;
/// a hit lies inside [range_min, range_max], every other beam holds `range_without_hit()` of its status. The
/// number of beams stays constant for the life of a source.
struct PlanarScan {
  std::string frame_id;
  Stamp stamp;                ///< first ray
  float angle_min = 0;        ///< rad
  float angle_max = 0;        ///< rad
  float angle_increment = 0;  ///< rad, may be negative (scanner mounted upside down)
  float time_increment = 0;   ///< s between neighbouring beams; negative: the last beam was measured first
  float scan_time = 0;        ///< s between scans
  float range_min = 0;        ///< m
  float range_max = 0;        ///< m
  std::size_t beams = 0;
  std::size_t echoes = 1;
  /// What messages hold for beams with status `none`; +inf (REP 117) unless an output's consumers need
  /// another value.
  float none_as = std::numeric_limits<float>::infinity();
  /// What messages hold for beams with status `invalid`: not observed.
  float invalid_as = std::numeric_limits<float>::quiet_NaN();
  std::vector<float> ranges;         ///< m, [echo * beams + beam]
  std::vector<float> intensities;    ///< device units; empty, or as long as ranges
  std::vector<BeamStatus> statuses;  ///< as long as ranges
  /// m per beam: nearer than that nothing was observed, though what lies beyond was; empty: 0 everywhere.
  /// Virtual scans have it, and scans without their first echo.
  std::vector<float> free_from;
  /// Messages cannot express it: they have the even angles.
  AngleWave wave;
  /// Flags of the device for each beam (sick::ms3_beam); empty: nothing beyond the status.
  std::vector<std::uint8_t> flags;

  std::size_t index(std::size_t beam, std::size_t echo = 0) const { return echo * beams + beam; }
  float even_angle(std::size_t beam) const { return angle_min + static_cast<float>(beam) * angle_increment; }
  /// Where the beam points, rad.
  float angle(std::size_t beam) const {
    return static_cast<float>(wave.bent(static_cast<double>(even_angle(beam))));
  }

  /// Sets the number of beams and echoes and makes every beam `invalid`. Allocates only when the size grows.
  void reset(std::size_t beam_count, std::size_t echo_count = 1, bool with_intensities = true);
  /// Sets the geometry; angle_max follows from the number of beams.
  void set_angles(float first, float increment);
  void set_hit(std::size_t i, float range_m) {
    ranges[i] = range_m;
    statuses[i] = BeamStatus::hit;
  }
  void set_without_hit(std::size_t i, BeamStatus status) {
    ranges[i] = range_without_hit(status);
    statuses[i] = status;
  }
  /// Makes the unwanted beams of a window, of which this is the scan, `invalid`.
  void hide_gap(const BeamWindow& window);
  /// Reverses the order of the beams. The stamp stays that of the first one in the message.
  void reverse();
  /// Stores a measured range, m: below range_min it is `near`, beyond range_max `none`.
  void set_measured(std::size_t i, float range_m) {
    if (range_m < range_min)
      set_without_hit(i, BeamStatus::near);
    else if (range_m > range_max)
      set_without_hit(i, BeamStatus::none);
    else
      set_hit(i, range_m);
  }
};

/// Writes what messages hold for beams of the first echo without a hit to `ranges`, which has those of
/// `scan`.
void encode_ranges(const PlanarScan& scan, float* ranges);

/// What is wrong with `scan` in a few words, or nullptr if all invariants hold.
const char* violation(const PlanarScan& scan);

}  // namespace lidard
