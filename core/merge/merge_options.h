// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

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

}  // namespace lidard
