// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/evidence/profile.h"
#include "core/evidence/visibility_table.h"

namespace lidard {

/// What is known about a beam of the output. `gap`: a surface, but the way to it was not observed. `behind`:
/// it was, but no source sees the surface from the side the beam comes from.
enum class BeamState : std::uint8_t { unobserved, free, hit, behind, gap };

struct VisibilitySettings {
  double noise = 0.02;       ///< the largest of the sources' standard deviations, m
  double gap = 0.3;          ///< so much of the way may go unobserved, m ...
  double gap_share = 0.05;   ///< ... or this share of the range, whichever is more
  double approach = 0.12;    ///< so far before a surface the way must be free, m
  double free_required = 0;  ///< how far a beam must be observed to be free, m; 0: range_max
  bool mean = false;         ///< surfaces that several sources see in one place are averaged
};

/// What can be said from the origin of an output frame about the surfaces and the free space that several
/// sources see: per beam the nearest surface, and whether the way to it is known to be free.
class Visibility {
 public:
  Visibility(const ScanGrid& grid, const VisibilitySettings& settings, std::size_t sources);

  /// The vehicle's outline in the output frame: the way inside it need not be observed.
  void set_footprint(const Footprint& footprint);
  /// Tells where a source looks from; needed once, and whenever it moves.
  void set_source(std::size_t source, const BeamRays& rays);
  /// Computes from the newest sweep of each source; nullptr: this source has none.
  void compute(const std::vector<const PlacedScan*>& sweeps);
  /// For what is no sweep: the place of all sources, m in the output's plane; their columns are `width` rad
  /// apart. The last source then is not what is seen to be free but what no beam can see: a surface counts
  /// although the way to it leads through, but no beam is free that does.
  void set_place(float x, float y, double width);
  /// Begins anew with surfaces and evidence that the caller fills in, in place of sweeps.
  void begin();
  const Raster& raster() const { return raster_; }
  RangeLayer& surfaces() { return nearest_; }
  RangeLayer& doubtful() { return doubtful_; }
  std::vector<char>& ends() { return ends_.marked; }
  FreeSpaceMap& free_space(std::size_t source) { return maps_[source]; }
  /// Computes from what was filled in.
  void compute();
  /// Writes the result in the words of a profile, `strict` or `safety`.
  void encode(Profile profile, PlanarScan& scan, bool with_intensities) const;

  std::size_t beams() const { return states_.size(); }
  BeamState state(std::size_t beam) const { return states_[beam]; }
  /// m to the nearest surface; infinite: none.
  float range(std::size_t beam) const { return nearest_.range[beam]; }
  /// m from the origin as far as the way is observed to be free.
  float covered(std::size_t beam) const { return covered_[beam]; }
  /// A beam that was found to be free is not; only `covered` m of it are.
  void withdraw_free(std::size_t beam, float covered) {
    if (states_[beam] != BeamState::free) return;
    states_[beam] = BeamState::unobserved;
    covered_[beam] = covered;
  }

 private:
  void combine(const std::vector<const PlacedScan*>& sweeps);
  void average(std::size_t beam);
  bool has_hit(std::size_t beam) const { return nearest_.range[beam] <= range_max_; }
  /// Finds which ways end where some source sees that nothing is.
  void look_at_ends();
  BeamState decide(std::size_t beam);
  /// Walks along the beam's way from where the vehicle ends; false at the first gap. Sets covered.
  bool is_covered(std::size_t beam, std::size_t sources);
  std::size_t row_of(std::size_t source) const { return one_place_ ? 0 : source; }
  /// The first step in [from, to) that this source does not see to be free, or `to`.
  std::size_t free_run(std::size_t source, std::size_t beam, std::size_t from, std::size_t to) const;

  VisibilitySettings settings_;
  Raster raster_;
  VisibilityTable table_;
  std::vector<BeamRays> rays_;
  std::vector<FreeSpaceMap> maps_;
  std::vector<RangeLayer> layers_;  // per source
  bool has_blind_ = false;          // the last map is what cannot be seen
  bool one_place_ = false;          // all sources look from there, so that they share the table's row
  std::size_t witness_ = 0;         // the source that saw the farthest part of the last way walked
  RangeLayer nearest_;
  RangeLayer doubtful_;
  EndLayer ends_;
  /// Where a beam leads through the vehicle; the way in there need not be observed.
  struct Inside {
    std::size_t from = 0, to = 0;  // steps [from, to)
    float end = 0;                 // m
  };
  float range_max_;                       // m
  float open_ = 0;                        // m that a beam without a hit must be free
  float approach_;                        // m before a hit
  std::vector<float> ways_;               // m of each beam that must be seen to be free
  std::vector<std::uint32_t> last_step_;  // of the way, and one
  std::vector<float> end_x_, end_y_;      // where they end
  std::vector<char> end_free_;
  std::vector<float> begin_;  // m, where the vehicle ends if the origin lies inside
  std::vector<Inside> inside_;
  std::vector<BeamState> states_;
  std::vector<float> covered_;
  std::vector<float> blind_to_;  // m of the last ways walked, up to which no beam can see
};

}  // namespace lidard
