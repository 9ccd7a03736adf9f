// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstddef>
#include <optional>

namespace lidard {

/// Neighbouring beams of a scan.
struct BeamWindow {
  std::size_t first = 0;
  std::size_t count = 0;
};

/// Which of `beams` beams, the first at `angle` and each `step` further (rad), lie between two limits. Limits
/// are rounded where they come from: a beam on one of them is inside.
inline BeamWindow beams_between(double angle, double step, std::size_t beams, std::optional<double> lowest,
                                std::optional<double> highest) {
  if (!lowest && !highest) return {0, beams};
  const double slack = 0.01 * std::abs(step);
  BeamWindow window;
  for (std::size_t i = 0; i < beams; ++i) {
    const double at = angle + step * static_cast<double>(i);
    if ((lowest && at < *lowest - slack) || (highest && at > *highest + slack)) continue;
    if (window.count++ == 0) window.first = i;
  }
  return window;
}

}  // namespace lidard
