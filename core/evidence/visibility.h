// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "core/evidence/crossings.h"
#include "core/evidence/outline.h"
#include "core/evidence/raster.h"
#include "core/frames/scan_grid.h"

namespace lidard {

/// What is known about a beam of the output. `free`: every point of the required way lies between two
/// neighbouring beams of one source that both passed it; an object in the beam would be narrower than the
/// space between these two. `hit`: the way to the surface is free, except for short parts where no source has
/// a beam and which no return hides. `gap`: a surface, but the way to it was not observed. `behind`: the way
/// was observed, but no source sees the surface from the side of the beam.
enum class BeamState : std::uint8_t { unobserved, free, hit, behind, gap };

struct VisibilitySettings {
  double noise = 0.02;      ///< the largest of the sources' standard deviations, m
  double gap = 0.3;         ///< longest part of the way to a hit that may be unobserved, m,
  double gap_share = 0.05;  ///< or this share of the range, whichever is more; in total twice as much
  double approach = 0.12;   ///< distance before a surface as far as which the way must be free, m
  /// All evidence is of the surfaces' own height: what is hidden as far as a surface hides that, too.
  bool one_level = true;
  double free_required = 0;  ///< range up to which a beam must be observed to be free, m; 0: range_max
};

/// The surfaces and the free space that several sources see, as seen from the origin of an output frame: per
/// beam the nearest surface, and whether the way to it is known to be free.
///
///   o---[vehicle]--A--->   The beam from o crosses the outlines of the vehicle and of the sources A and B.
///       in      out/in     A walk along its crossings counts the layers of free and of hidden space that
///      ....B......  out    hold the beam: where no layer is free, the way is unseen; where then a layer is
///                          hidden, a return hides it.
class Visibility {
 public:
  /// What the free space of an outline means. `seen`: something would have been met there. `blind`: no beam
  /// of a lidar can look there; a surface counts although the way to it leads through, but no beam is free
  /// that does. `over`: beams lead over it, and what hides it is likely lower than the plane: it proves
  /// nothing, but holds no body either. `front`: blind, and what ends it is the top of a thing whose front
  /// begins somewhere in it: a surface at the end of it does not count.
  enum Kind : std::uint8_t { seen, blind, over, front, kinds };

  /// For sweeps of `sources` scanners, or for the evidence of so many lidars that the caller fills in.
  Visibility(const ScanGrid& grid, const VisibilitySettings& settings, std::size_t sources);

  /// The vehicle's outline in the output frame: the way inside it need not be observed.
  void set_footprint(const Footprint& footprint);
  /// Where the vehicle was when the oldest beam was measured: nothing else was there. `former_from_now` maps
  /// points of the output frame now to those of then; none: it stood.
  void set_former(const std::optional<Pose>& former_from_now) { former_from_now_ = former_from_now; }
  /// Sets the beams of a source; call it once and whenever the source's mount changes.
  void set_source(std::size_t source, const BeamRays& rays) { rays_[source] = rays; }
  /// What the sweeps of a source prove: `seen` unless set.
  void set_kind(std::size_t source, Kind kind) { sweep_kinds_[source] = kind; }
  /// Computes from the newest sweep of every source; nullptr: the source has none.
  void compute(const std::vector<const PlacedScan*>& sweeps);

  /// Begins anew with surfaces and outlines that the caller fills in, in place of sweeps.
  void begin();
  const Raster& raster() const { return raster_; }
  RangeLayer& surfaces() { return nearest_; }
  /// The outlines, ready to add those of one kind of a source whose beams are `step` rad apart and which is
  /// `distance` m from the origin.
  Outlines& outlines(std::size_t source, Kind kind, double step, double distance);
  /// Computes from what was filled in.
  void compute();

  /// Encodes the result for profile `strict` or `safety`.
  void encode(Profile profile, PlanarScan& scan, bool with_intensities) const;

  std::size_t beams() const { return states_.size(); }
  BeamState state(std::size_t beam) const { return states_[beam]; }
  /// m to the nearest surface; infinite: none.
  float range(std::size_t beam) const { return nearest_.range[beam]; }
  /// m from the origin to the end of the observed free way.
  float covered(std::size_t beam) const { return covered_[beam]; }

 private:
  /// Layers of free and hidden space of an outline's source at a point of a beam.
  struct Layers {
    int free = 0, hidden = 0;
    float behind = 0;  // m from a hiding return to where the beam entered hidden space
  };
  /// A stretch of a beam's way that no source sees.
  struct Unseen {
    float from = 0;                                              // m
    float hidden_from = std::numeric_limits<float>::infinity();  // a return hides the stretch from here on
    float behind = std::numeric_limits<float>::infinity();       // m from that return
  };
  /// A walk along a beam.
  struct Walk {
    std::size_t beam;
    bool has_hit;
    float end;                      // m, of the way that must be seen
    std::array<int, kinds> free{};  // layers that hold the point, by kind,
    int hidden = 0;                 // and those in which a return hides it
    float unseen = 0;               // m, in total
    bool covered = true;
    Unseen stretch{};
    float front_from = 0, front_to = 0;  // m, of the newest part of which `front` alone is known
    /// A surface counts although the way to it leads through what is blind.
    bool is_free() const { return free[seen] > 0 || (has_hit && is_blind()); }
    bool is_blind() const { return free[seen] == 0 && (free[blind] > 0 || free[front] > 0); }
    bool is_front() const { return free[seen] == 0 && free[front] > 0; }
  };
  bool has_hit(std::size_t beam) const { return nearest_.range[beam] <= range_max_; }
  void add_vehicle(const Footprint& body);
  BeamState decide(std::size_t beam);
  void begin_walk(Walk& walk);
  void cross(Walk& walk, const Crossings::Crossing& crossing);
  void pass_unseen(Walk& walk, float from, float to) const;
  void end_unseen(Walk& walk, float to);
  float behind(std::size_t beam, const Crossings::Crossing& crossing) const;

  VisibilitySettings settings_;
  Raster raster_;
  std::vector<BeamRays> rays_;
  std::vector<Kind> sweep_kinds_;
  Footprint body_;
  std::optional<Pose> former_from_now_;
  float range_max_;           // m
  float open_;                // m that a beam without a hit must be free
  float approach_;            // m before a hit
  bool has_columns_ = false;  // evidence of lidars that the caller fills in, in place of sweeps
  float column_ =
      0;  // m per m of range before a hit, beside that: a column sees a slanting wall at one distance
  Outlines outlines_;
  Crossings crossings_;
  RangeLayer nearest_;
  RangeLayer mixed_pixels_;
  std::vector<std::uint16_t> outline_of_;  // by source and kind: of those that there are
  std::vector<Kind> kind_of_;              // of the outlines, the vehicle's last
  std::vector<Layers> layers_;             // of the outlines, in the same order
  std::vector<BeamState> states_;
  std::vector<float> covered_;
  std::vector<float> body_at_;   // m to where the way leads into the space behind a return; infinite: nowhere
  std::vector<float> blind_to_;  // m to the end of the way that no beam can see
  std::vector<char> from_behind_;  // the surface is seen from its other side alone
};

}  // namespace lidard
