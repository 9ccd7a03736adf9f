// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/time.h"
#include "core/evidence/free_space_map.h"
#include "core/merge/merge_options.h"

namespace lidard {

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

}  // namespace lidard
