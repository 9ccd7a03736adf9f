// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "core/base/angle.h"
#include "core/evidence/beam_rays.h"
#include "core/frames/scan.h"
#include "core/motion/frame_motion.h"

namespace lidard {

/// Which returns of a beam are used. `all`: the last one as surface, the earlier ones as points.
enum class EchoChoice : std::uint8_t { first, last, strongest, all };

/// Properties of a source and the windows in which its returns are used.
struct SourceSettings {
  double noise = 0.02;  ///< one standard deviation of a range, m
  EchoChoice echoes = EchoChoice::last;
  double range_min = 0;  ///< m
  double range_max = std::numeric_limits<double>::infinity();
  std::optional<double> angle_min, angle_max;  ///< rad, sensor frame: the sector that counts
  /// Free range that a beam without return proves, m; infinite: the scan's range_max.
  double no_return_free_range = std::numeric_limits<double>::infinity();
  bool veil_filter = true;
  /// False: surfaces count where this source sees the way, but no beam is free that it alone sees.
  bool proves_free = true;

  /// True if hit `i` of a scan lies in the windows of range and angle.
  bool wants(const PlanarScan& scan, std::size_t i) const {
    const auto range = static_cast<double>(scan.ranges[i]);
    if (range < range_min || range > range_max) return false;
    return sector_between(angle_min, angle_max)
        .holds(static_cast<double>(scan.angle_min) +
               static_cast<double>(i % scan.beams) * static_cast<double>(scan.angle_increment));
  }
};

/// What the return of a beam is. `mixed_pixel`: it lies between two surfaces, where no surface is
/// (mark_mixed_pixels()).
enum class Return : std::uint8_t { nothing, surface, mixed_pixel };

/// One sweep of a source in the output frame, without returns from the vehicle itself. Buffers keep their
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

  /// A return before the one that is used as surface.
  struct EarlyReturn {
    std::size_t beam;
    float range;  ///< m
    float intensity;
  };

  /// A return that one beam alone meets, while the beams on both sides pass at least `lone_depth` beyond: a
  /// drop, dust, a leaf. It hides nothing wider than two spaces between beams. A return that was there in the
  /// sweep before is a `thing`: a rod.
  struct LoneReturn {
    std::size_t beam;  ///< never the first or the last one
    float range;       ///< m
    bool thing;
  };
  static constexpr float lone_depth = 0.5F;  ///< m

  std::vector<float> range;  ///< m along the beam
  std::vector<Return> kind;
  std::vector<float> intensity;  ///< empty, or as long as range
  /// `near`: the returns of beams i and i + 1 are near to each other, but no third return shows one surface.
  /// It is drawn, but what lies before it is not free.
  enum Link : char { apart, linked_surely, near };
  std::vector<char> linked;      ///< Link: beams i and i + 1 lie on one surface
  std::vector<float> free_from;  ///< m level from the source: begin of the beam's free part
  std::vector<float> free_to;    ///< m level from the source: end of the beam's free part; 0: no evidence
  std::vector<LoneReturn> lone_returns;
  std::vector<LoneReturn> lone_before;  ///< of the sweep before
  std::vector<EarlyReturn> early_returns;
  /// Once a return has come from beyond the vehicle's outline, the beam passes the vehicle. Clear it when the
  /// scanner's rays change.
  std::vector<char> passes_vehicle;
  std::uint64_t own_returns = 0;   ///< on the vehicle itself, since the start
  std::uint64_t seen_through = 0;  ///< returns from beyond the vehicle's outline, since the start
  std::uint64_t mixed_pixels = 0;  ///< mixed pixels, since the start

  // The following members are in the output frame at the instant of the output.
  std::vector<float> x, y;          ///< m; valid where kind is not `nothing`
  std::vector<Corner> corners;      ///< by increasing beam
  std::vector<Point> early_echoes;  ///< positions of the early returns
  bool moved = false;               ///< the vehicle moved; free_x and free_y are valid
  std::vector<float> free_x,
      free_y;  ///< m from the source's position at the instant to the end of the free way
  std::vector<float> origin_x, origin_y;  ///< m from that position to where each beam began
};

/// Fills `sweep` from a scan (conditioning, continuity, mixed pixels), except for the members in the output
/// frame. The scan must satisfy its invariants and `rays` must be built for it.
void measure(const PlanarScan& scan, const BeamRays& rays, const SourceSettings& settings, PlacedScan& sweep);

/// Computes the members of `sweep` in the output frame; `noise` as in SourceSettings.
void transform(const BeamRays& rays, const SweepMotion& motion, double noise, PlacedScan& sweep);

/// measure() and transform() for a vehicle at rest.
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
/// Two returns belong to one surface if the angle between surface and beam can be at least 10 degrees (9
/// here, to leave room at the limit): with ranges a <= b, s the angle between the beams, l = 9 degrees and
/// sigma the noise
///     |P_a P_b| <= a sin(s) / sin(l - s) + 3 sigma.
/// Four returns on one line are a wall at a more grazing angle. A steep link between two surfaces that both
/// continue is removed: with coarse beams the rule alone would bridge steps of more than a metre.
void link_neighbours(const BeamRays& rays, double noise, PlacedScan& sweep);

/// Marks mixed pixels and unlinks them. A mixed pixel (veil_filter; shadow point in ROS' laser_filters)
/// arises where a beam touches the edge of a near surface and the far surface behind it: it measures a range
/// in between, where nothing is. Returns of a wall along the beam are exempt.
void mark_mixed_pixels(const BeamRays& rays, double noise, PlacedScan& sweep);

/// Finds corners: the surfaces on either side of two linked returns meet between them, where a straight line
/// would cut the corner off. Needs x and y.
void find_corners(double noise, PlacedScan& sweep);

}  // namespace lidard
