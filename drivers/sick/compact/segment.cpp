// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/compact/segment.h"

#include <cmath>

namespace lidard::sick {

bool is_plausible(const SegmentLine& line) {
  // So that nanoseconds since 1970 fit into 63 bits.
  constexpr std::uint64_t latest_us = 9'000'000'000'000'000;
  constexpr std::uint64_t longest_us = 2'000'000;
  constexpr double farthest = 7;  // rad: a segment of a multiScan100 may run beyond pi
  if (line.start_us > latest_us || line.stop_us < line.start_us) return false;
  if (line.stop_us - line.start_us > longest_us) return false;
  for (const double angle : {line.elevation, line.theta_start, line.theta_stop}) {
    if (!(std::fabs(angle) <= farthest)) return false;
  }
  return line.metres > 0 && line.metres < 1;
}

}  // namespace lidard::sick
