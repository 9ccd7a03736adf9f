// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/time.h"
#include "core/evidence/free_space_map.h"
#include "core/evidence/visibility.h"

namespace lidard {

/// Whether merged scans have intensities. `automatic`: where all sources have them.
enum class Intensities : std::uint8_t { automatic, on, off };

/// What a merge does beside what it always does.
struct MergeOptions {
  bool newest_wins = false;  ///< a hit inside what a newer sweep of another source sees through is dropped
  bool all_heights = false;  ///< a beam is free only where the sources of every mounting height say so
  bool veil_cross_check = false;  ///< a return that another source sees through is doubtful
  Intensities intensities = Intensities::automatic;
  float missing_intensity = 0;  ///< of sources without intensities, with Intensities::on
};

/// Judges each source's returns by what the other sources see: where another one looks on by more than 0.1 m
/// (and more than five standard deviations), two of its beams to either side too, nothing can be. What is
/// thinner than that may be wronged.
class CrossCheck {
 public:
  /// Ranges end at `range_max`, m; `noise` is the largest of the sources' standard deviations, m.
  CrossCheck(const MergeOptions& options, std::size_t sources, double range_max, double noise);

  /// Tells where a source looks from; needed once, and whenever it moves.
  void set_source(std::size_t source, const BeamRays& rays);
  /// Puts checked copies in the place of the sweeps that need one; `ends` are the times of their last rays.
  /// The copies stay valid until the next call.
  void check(std::vector<const PlacedScan*>& sweeps, const std::vector<Stamp>& ends);

  /// Returns found doubtful, and hits dropped since a newer sweep looks on.
  std::uint64_t veils() const { return veils_; }
  std::uint64_t conflicts() const { return conflicts_; }

 private:
  struct Source {
    FreeSpaceMap map;
    float two_beams = 0;  // rad
    PlacedScan checked;
  };
  bool sees_through(const Source& source, float x, float y) const;
  void check_source(std::size_t index, const std::vector<const PlacedScan*>& sweeps,
                    const std::vector<Stamp>& ends);
  static void unlink(std::size_t beam, PlacedScan& sweep);

  MergeOptions options_;
  double unit_;   // m, of the maps
  float margin_;  // m
  std::vector<Source> sources_;
  std::uint64_t veils_ = 0;
  std::uint64_t conflicts_ = 0;
};

/// Lets a beam of a merged scan be free only where the sources of every mounting height see it to be: what is
/// free for a scanner at knee height may hold a table top. Mounts within 0.1 m of each other are one height.
class HeightGroups {
 public:
  HeightGroups(const ScanGrid& grid, const VisibilitySettings& settings, std::size_t sources);

  /// The vehicle's outline in the output frame.
  void set_footprint(const Footprint& footprint);
  /// Tells where a source looks from; needed once, and whenever it moves. Until it is told, nothing is free.
  void set_source(std::size_t source, const BeamRays& rays);
  /// Takes back what `visibility`, computed from these sweeps, calls free and not every height does.
  void require(const std::vector<const PlacedScan*>& sweeps, Visibility& visibility);

 private:
  struct Member {
    bool known = false;
    BeamRays rays;
    std::size_t group = 0;
  };
  void group();

  ScanGrid grid_;
  VisibilitySettings settings_;
  Footprint footprint_;
  std::vector<Member> members_;
  std::vector<Visibility> groups_;
  bool grouped_ = false;
  std::vector<const PlacedScan*> of_group_;
};

}  // namespace lidard
