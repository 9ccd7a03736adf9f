// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "core/base/angle.h"
#include "core/evidence/beam_rays.h"
#include "core/frames/scan.h"
#include "core/motion/frame_motion.h"

namespace lidard {

/// Which of a beam's returns count. `all`: the last one is surface, the earlier ones are points.
enum class EchoChoice : std::uint8_t { first, last, strongest, all };

/// What is known about a source, and which of its returns are wanted.
struct SourceSettings {
  double noise = 0.02;  ///< one standard deviation of a range, m
  EchoChoice echoes = EchoChoice::last;
  double range_min = 0;  ///< m
  double range_max = std::numeric_limits<double>::infinity();
  double angle_min = -std::numeric_limits<double>::infinity();  ///< rad, sensor frame
  double angle_max = std::numeric_limits<double>::infinity();
  /// How far a beam without return proves that nothing is there, m; infinite: to the scan's range_max.
  double no_return_free_range = std::numeric_limits<double>::infinity();
  bool veil_filter = true;

  /// True if the hit `i` of a scan lies in all windows.
  bool wants(const PlanarScan& scan, std::size_t i) const;
};

/// What a beam is worth. `doubtful`: a veil point (mark_veils()), between two surfaces where no surface is.
enum class Return : std::uint8_t { nothing, surface, doubtful };

/// One sweep of a source, freed of what is not the world's, seen from the output frame. Buffers keep their
/// memory.
struct PlacedScan {
  struct Point {
    float x, y;  ///< m, output frame
    float intensity;
  };

  /// Where two surfaces meet between beam `beam` and the next one.
  struct Corner {
    std::size_t beam;
    Point at;
  };

  /// A return before the one that is surface.
  struct EarlyReturn {
    std::size_t beam;
    float range;  ///< m
    float intensity;
  };

  std::vector<float> range;  ///< m along the beam
  std::vector<Return> kind;
  std::vector<float> intensity;  ///< empty, or as long as range
  std::vector<char> linked;      ///< beam i and i + 1 lie on one surface
  std::vector<float> free_from;  ///< m level from the source; the beam is free from here ...
  std::vector<float> free_to;    ///< ... to here; 0: no evidence
  std::vector<EarlyReturn> early_returns;
  std::uint64_t own_returns = 0;   ///< on the vehicle itself, since the start
  std::uint64_t seen_through = 0;  ///< returns from behind the vehicle's body, since the start
  std::uint64_t veils = 0;         ///< veil points, since the start

  // What follows is in the output frame as it stands at the output's instant.
  std::vector<float> x, y;            ///< m; valid where kind is not `nothing`
  std::vector<Corner> corners;        ///< by increasing beam
  std::vector<Point> early_echoes;    ///< places of the early returns
  bool moved = false;                 ///< the vehicle moved; then:
  std::vector<float> free_x, free_y;  ///< m from the source's place at the instant to the end of the free way
};

/// Fills `sweep` from a scan (conditioning, continuity, veil filter) but for places.
/// The scan must hold its invariants and `rays` be built for it.
void measure(const PlanarScan& scan, const BeamRays& rays, const SourceSettings& settings, PlacedScan& sweep);

/// Places what was measured in the output frame; `noise` as in SourceSettings.
void place(const BeamRays& rays, const SweepMotion& motion, double noise, PlacedScan& sweep);

/// measure() and place(), for a vehicle that stands.
void condition(const PlanarScan& scan, const BeamRays& rays, const SourceSettings& settings,
               PlacedScan& sweep);

/// Limits of the adaptive breakpoint rule (Borges and Aldon, "Line extraction in 2D range images for mobile
/// robotics", 2004), for neighbouring beams of a scan and of a cloud alike.
namespace breakpoint {
constexpr double steepest = 9 * rad_per_deg;  // between surface and beam
constexpr float longest_grazing_step = 3;     // m
constexpr float steady_growth = 2.5F;         // of the steps along a wall
constexpr float line_tolerance = 0.005F;      // m, beside the noise
}  // namespace breakpoint

/// Sets `sweep.linked`: which neighbouring returns belong to one surface.
///
/// Two returns are one surface if it need not be steeper than 10 degrees against the beam (9 here, to leave
/// room at the limit): with ranges a <= b, s the angle between the beams, l = 9 degrees and sigma the noise
///     |P_a P_b| <= a sin(s) / sin(l - s) + 3 sigma.
/// A wall seen at a more grazing angle is recognised by four returns on one line. A steep link between two
/// surfaces that both go on is none: between coarse beams the rule alone would bridge steps of more than a
/// metre.
void link_neighbours(const BeamRays& rays, double noise, PlacedScan& sweep);

/// Marks veil points `doubtful` and unlinks them. A veil point is what is elsewhere called a mixed pixel or a
/// shadow point (ROS: laser_filters' ScanShadowsFilter): a beam that touches the edge of a near surface and
/// the far one behind it measures a range in between, where nothing is. Returns of a wall along the beam are
/// exempt.
void mark_veils(const BeamRays& rays, double noise, PlacedScan& sweep);

/// Finds corners: two linked returns, with further ones on either side, whose surfaces meet between them.
/// Without the corner the straight line between both returns would cut it off. Needs the places.
void find_corners(double noise, PlacedScan& sweep);

}  // namespace lidard
