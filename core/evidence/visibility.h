// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/evidence/free_space_map.h"
#include "core/evidence/raster.h"
#include "core/evidence/visibility_table.h"
#include "core/frames/scan_grid.h"

namespace lidard {

/// What is known about a beam of the output. `free`: every place of the required way lies between two
/// neighbouring beams of one source that both passed it; an object in the beam would be narrower than the
/// space between these two. `hit`: the way to the surface is free, except for short parts where no source has
/// a beam and which no return hides. `gap`: a surface, but the way to it was not observed. `behind`: the way
/// was observed, but no source sees the surface from the side of the beam.
enum class BeamState : std::uint8_t { unobserved, free, hit, behind, gap };

struct VisibilitySettings {
  double noise = 0.02;       ///< the largest of the sources' standard deviations, m
  double gap = 0.3;          ///< longest part of the way to a hit that may be unobserved, m,
  double gap_share = 0.05;   ///< or this share of the range, whichever is more; in total twice as much
  double approach = 0.12;    ///< distance before a surface as far as which the way must be free, m
  double free_required = 0;  ///< range up to which a beam must be observed to be free, m; 0: range_max
};

/// The surfaces and the free space that several sources see, as seen from the origin of an output frame: per
/// beam the nearest surface, and whether the way to it is known to be free.
class Visibility {
 public:
  Visibility(const ScanGrid& grid, const VisibilitySettings& settings, std::size_t sources);

  /// The vehicle's outline in the output frame: the way inside it need not be observed.
  void set_footprint(const Footprint& footprint);
  /// Where the vehicle was when the oldest beam was measured: nothing else was there. `former_from_now` maps
  /// places of the output frame now to those of then; none: it stood.
  void set_former(const std::optional<Pose>& former_from_now) { former_from_now_ = former_from_now; }
  /// Sets the beams of a source; call it once and whenever the source moves.
  void set_source(std::size_t source, const BeamRays& rays);
  /// Computes from the newest sweep of every source; nullptr: the source has none.
  void compute(const std::vector<const PlacedScan*>& sweeps) {
    combine(sweeps);
    compute();
  }
  /// For what is no sweep: `places` places, from each of which an equal number of sources looks, in turns:
  /// source s looks from place s modulo `places`. The first `observing` sources are what is seen to be free.
  /// Then comes from each place what no beam can see from there, with the free way that follows; the others
  /// are free more likely than not: a surface counts although the way to it leads through, but no beam is
  /// free that does.
  void set_places(std::size_t places, std::size_t observing);
  /// Where place `place` is, m in the output's plane; the columns of its sources are `width` rad apart.
  void set_place(std::size_t place, float x, float y, double width);
  /// Begins anew with surfaces and evidence that the caller fills in, in place of sweeps.
  void begin();
  const Raster& raster() const { return raster_; }
  RangeLayer& surfaces() { return nearest_; }
  FreeSpaceMap& free_space(std::size_t source) { return maps_[source]; }
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
  /// True if every point of the beam's way is seen, by a slow method that shares only the free space of the
  /// sources with compute(). For tests and debug builds.
  bool is_seen_all_along(std::size_t beam) const;

 private:
  void combine(const std::vector<const PlacedScan*>& sweeps);
  bool has_hit(std::size_t beam) const { return nearest_.range[beam] <= range_max_; }
  /// Computes the required way of every beam and the place of its end for every source.
  void find_ends();
  BeamState decide(std::size_t beam);
  /// Walks along the beam's way from the vehicle's border; false if the way is not observed. Sets covered_.
  bool is_covered(std::size_t beam, std::size_t sources);
  /// The table's row, and the first of the sources that look from one place.
  std::size_t row_of(std::size_t source) const { return row_of_[source]; }
  bool is_blind(std::size_t source) const { return source >= observing_ && source < observing_ + rows_; }
  /// The first stretch in steps [from, to), from a stretch's begin, that the source does not see to be free
  /// completely.
  std::size_t free_stretches(std::size_t source, std::size_t beam, std::size_t from, std::size_t to) const;
  /// The first step in [from, to), all in one stretch, that the source does not see to be free, or `to`.
  std::size_t free_run(std::size_t source, std::size_t beam, std::size_t from, std::size_t to) const;
  /// Finds for each wedge the first step of the first stretch that no single source sees in all of its beams.
  void find_open_wedges();
  /// State of a walk along a beam.
  struct Walk {
    std::size_t beam, sources;
    std::size_t last;      // step that holds the end of the way
    std::size_t source;    // to be queried next
    float at = 0;          // m, walked so far
    float known = 0;       // m, end of the last piece that was seen
    float unseen = 0;      // m in total where no source has a beam
    std::size_t body = 0;  // the piece of the vehicle last walked through
  };
  void see(Walk& walk, std::size_t source, float to);
  static void next_source(Walk& walk) { walk.source = walk.source + 1 < walk.sources ? walk.source + 1 : 0; }
  /// The first stretch in steps [from, to), from a stretch's begin, that no single source sees completely.
  std::size_t seen_stretches(Walk& walk, std::size_t from, std::size_t to);
  /// The first step in [from, to) that no source sees to be free, or `to`.
  std::size_t seen_run(Walk& walk, std::size_t from, std::size_t to);
  /// True if a source sees the way from step `step` (from the vehicle's border in it) to the begin of step
  /// `to`, or to the end of the way if `to` is beyond the last step.
  bool sees_piece(Walk& walk, std::size_t step, bool from_body, std::size_t to);
  /// Walks through a step that no single source sees completely; false if the way is not observed.
  bool cross_step(Walk& walk, std::size_t step, bool from_body, bool covered);
  /// Walks from `from` to `to` m in parts of a step; false if a part is not observed.
  bool accept(Walk& walk, float from, float to);
  /// True if walking on along a way that was not observed cannot change the result.
  bool is_decided(std::size_t beam) const { return !has_hit(beam) || body_at_[beam] <= range_max_; }
  /// True if a step leads through the space shortly behind a return.
  bool may_hold_body(const Walk& walk, std::size_t step) const;
  /// True if part `part` of a step, from `from` m to walk.at, may stay unseen.
  bool accept_unseen(Walk& walk, float from, std::size_t part);
  /// True if the vehicle itself was at that place of the beam.
  bool was_inside(std::size_t beam, float range) const {
    const Eigen::Vector3d place(range * raster_.cosine(beam), range * raster_.sine(beam), 0);
    return former_from_now_ && body_.contains((*former_from_now_ * place).head<2>());
  }
  bool is_open_to_some(const Walk& walk, std::size_t part) const;
  float seen_from(std::size_t beam);
  FreeSpaceMap::Place place_at(std::size_t source, std::size_t beam, float range) const {
    return maps_[source].place_of(range * raster_.cosine(beam), range * raster_.sine(beam));
  }
  /// Computes what depends on the place of a row's sources and on the vehicle's outline alone.
  void find_ways(std::size_t row);

  VisibilitySettings settings_;
  Raster raster_;
  VisibilityTable table_;
  std::vector<BeamRays> rays_;
  std::vector<FreeSpaceMap> maps_;
  std::vector<RangeLayer> layers_;  // per source
  std::size_t observing_;           // maps of what is seen to be free; the next ones are what cannot be seen
  std::size_t rows_;                // of the table: one for each place from which sources look
  std::vector<std::size_t> row_of_;
  std::size_t witness_ = 0;    // the source that saw the farthest part of the last way walked
  std::size_t seen_from_ = 0;  // the step from which on the last way was seen
  RangeLayer nearest_;
  RangeLayer mixed_pixels_;
  /// A piece of a beam's way that leads through the vehicle; it need not be observed.
  struct Inside {
    std::size_t from, to;  // the first and the last step
    float end;             // m
  };
  Footprint body_;
  std::optional<Pose> former_from_now_;
  float range_max_;            // m
  float open_ = 0;             // m that a beam without a hit must be free
  float approach_;             // m before a hit
  float column_ = 0;           // and so much of its range: a column sees a slanting wall at one distance
  std::vector<float> widths_;  // rad, of the columns at each place
  std::vector<float> ways_;    // m of each beam that must be seen to be free
  std::vector<float> end_x_, end_y_;                         // where they end
  std::vector<std::vector<FreeSpaceMap::Place>> way_ends_;   // of each row, by beam
  std::vector<std::vector<FreeSpaceMap::Place>> body_ends_;  // of each row, the ends of inside_
  /// A step that no single source sees completely is checked in this number of parts.
  static constexpr std::size_t parts_of_step = 4;
  /// Where the parts begin, and the end of the last one; so many more that all are computed at once.
  using Parts = std::array<FreeSpaceMap::Place, 2 * parts_of_step>;
  std::vector<Parts> parts_;  // of the current step, per place from which sources look
  std::vector<float> begin_;  // m, the vehicle's border if the origin lies inside
  std::vector<Inside> inside_;
  std::vector<std::size_t> pieces_;  // the first of each beam in inside_, and the number of all
  std::vector<BeamState> states_;
  std::vector<std::size_t> open_to_;  // of each wedge
  std::vector<float> covered_;
  std::vector<float> body_at_;   // m to where the way leads into the space behind a return; infinite: nowhere
  std::vector<float> blind_to_;  // m, begin of the way that no beam can see
};

}  // namespace lidard
