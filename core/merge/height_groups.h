// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "core/evidence/visibility.h"

namespace lidard {

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
