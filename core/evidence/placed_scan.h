// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "core/evidence/beam_rays.h"
#include "core/frames/scan.h"
#include "core/motion/sweep_motion.h"

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
  double intensity_min = -std::numeric_limits<double>::infinity();
  double intensity_max = std::numeric_limits<double>::infinity();
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

}  // namespace lidard
