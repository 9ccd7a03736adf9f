// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "core/evidence/raster.h"
#include "core/evidence/visibility.h"
#include "core/frames/scan_grid.h"
#include "test/support/outline.h"
#include "test/support/outline_crossings.h"

namespace lidard::outlines {

/// The surfaces and the free space that several sources see, as seen from the origin of an output frame: per
/// beam the nearest surface, and whether the way to it is known to be free.
///
///   o---[vehicle]--A--->   The beam from o crosses the outlines of the vehicle and of the sources A and B.
///       in      out/in     A walk along its crossings counts the layers of free and of hidden space that
///      ....B......  out    hold the beam: where no layer is free, the way is unseen; where then a layer is
///                          hidden, a return hides it.
class OutlineVisibility {
 public:
  OutlineVisibility(const ScanGrid& grid, const VisibilitySettings& settings, std::size_t sources);

  /// The vehicle's outline in the output frame: the way inside it need not be observed.
  void set_footprint(const Footprint& footprint);
  /// Where the vehicle was when the oldest beam was measured: nothing else was there. `former_from_now` maps
  /// points of the output frame now to those of then; none: it stood.
  void set_former(const std::optional<Pose>& former_from_now) { former_from_now_ = former_from_now; }
  /// Sets the beams of a source; call it once and whenever the source's mount changes.
  void set_source(std::size_t source, const BeamRays& rays) { rays_[source] = rays; }
  /// Computes from the newest sweep of every source; nullptr: the source has none.
  void compute(const std::vector<const PlacedScan*>& sweeps);
  /// Encodes the result for profile `strict` or `safety`.
  void encode(Profile profile, PlanarScan& scan, bool with_intensities) const;

  std::size_t beams() const { return states_.size(); }
  BeamState state(std::size_t beam) const { return states_[beam]; }
  /// m to the nearest surface; infinite: none.
  float range(std::size_t beam) const { return nearest_.range[beam]; }
  /// m from the origin to the end of the observed free way.
  float covered(std::size_t beam) const { return covered_[beam]; }

 private:
  /// Layers of free and hidden space of a source at a point of a beam.
  struct Layers {
    int free = 0, hidden = 0;
    float behind = 0;  // m from a hiding return to where the beam entered hidden space
  };
  /// A stretch of a beam's way that no source sees.
  struct Unseen {
    float from = 0;                                               // m
    float hidden_from = std::numeric_limits<float>::infinity();  // a return hides the stretch from here on
    float behind = std::numeric_limits<float>::infinity();       // m from that return
  };
  /// A walk along a beam.
  struct Walk {
    std::size_t beam;
    bool has_hit;
    float end;         // m, of the way that must be seen
    int free = 0;      // sources that see the place to be free,
    int hidden = 0;    // and from which a return hides it
    float unseen = 0;  // m, in total
    bool covered = true;
    Unseen stretch{};
    bool is_free() const { return free > 0; }
  };
  bool has_hit(std::size_t beam) const { return nearest_.range[beam] <= range_max_; }
  BeamState decide(std::size_t beam);
  void begin_walk(Walk& walk);
  void cross(Walk& walk, const Crossings::Crossing& crossing);
  void pass_unseen(Walk& walk, float from, float to) const;
  void end_unseen(Walk& walk, float to);
  float behind(const Outlines::Edge& edge, std::size_t beam, float at) const;

  VisibilitySettings settings_;
  Raster raster_;
  std::vector<BeamRays> rays_;
  Footprint body_;
  std::optional<Pose> former_from_now_;
  float range_max_;  // m
  float open_;       // m that a beam without a hit must be free
  float approach_;   // m before a hit
  Outlines outlines_;
  Crossings crossings_;
  RangeLayer nearest_;
  RangeLayer mixed_pixels_;
  std::vector<Layers> layers_;  // in that order
  std::vector<BeamState> states_;
  std::vector<float> covered_;
  std::vector<float> body_at_;  // m to where the way leads into the space behind a return; infinite: nowhere
};

}  // namespace lidard::outlines
