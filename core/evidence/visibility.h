// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "core/evidence/free_space_map.h"
#include "core/evidence/raster.h"
#include "core/frames/scan_grid.h"

namespace lidard {

/// Where the beams of an output scan lead through the views of the sources: for every beam, every source and
/// a row of steps outward, the source's cell that the step lies in and its distance from the source. Built
/// once per mounting, so that the walk along a beam is a row of look-ups.
class VisibilityTable {
 public:
  struct Step {
    std::uint16_t cell;
    std::uint16_t distance;  ///< units of the map
  };

  /// So many steps at once: the cells they lie in, and between which distances of the source.
  struct Stretch {
    FreeSpaceMap::RunAt cells;
    std::int16_t nearest;       ///< ordered() as in FreeSpaceMap::Run
    std::int16_t not_farthest;  ///< turned over
    bool is_free(const FreeSpaceMap::Run* runs) const {
      const FreeSpaceMap::Run a = runs[cells.first];
      const FreeSpaceMap::Run b = runs[cells.second];
      return std::max(a.from, b.from) <= nearest && std::max(a.not_to, b.not_to) <= not_farthest;
    }
  };
  static constexpr std::size_t stretch_steps = 8;

  /// Sets the steps for beams that are looked along as far as `range_max`, m.
  explicit VisibilityTable(const Raster& raster);

  /// Fills in one of `sources` sources.
  void set(std::size_t source, std::size_t sources, const Raster& raster, const FreeSpaceMap& map);

  std::size_t steps() const { return middles_.size(); }
  /// Where step m begins, m from the origin; edge(steps()) is where the last one ends.
  float edge(std::size_t m) const { return edges_[m]; }
  /// The first step whose middle is not nearer than `range`.
  std::size_t step_at(float range) const;
  /// The number of steps that begin before `range`.
  std::size_t steps_to(float range) const;
  /// Steps stretch_steps * k and the following ones of a beam, and what they have in common. Those of beams
  /// side by side lie side by side: that is how they are looked at.
  const Step* steps(std::size_t beam, std::size_t source, std::size_t k) const {
    return steps_.data() + index(beam, source, k) * stretch_steps;
  }
  const Stretch& stretch(std::size_t beam, std::size_t source, std::size_t k) const {
    return stretches_[index(beam, source, k)];
  }
  const Step& step(std::size_t beam, std::size_t source, std::size_t m) const {
    return steps(beam, source, m / stretch_steps)[m % stretch_steps];
  }

 private:
  std::size_t index(std::size_t beam, std::size_t source, std::size_t k) const {
    return (source * stretches_of_beam_ + k) * beams_ + beam;
  }
  static Stretch stretch_of(const Step* steps, const FreeSpaceMap& map);

  std::vector<float> edges_;
  std::vector<std::uint32_t> steps_to_;  // for every shortest step, the steps that begin before its end
  std::vector<float> middles_;
  std::size_t sources_ = 0;
  std::size_t beams_;
  std::size_t stretches_of_beam_;
  std::vector<Step> steps_;
  std::vector<Stretch> stretches_;
};

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
