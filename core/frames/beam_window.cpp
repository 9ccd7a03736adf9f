// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/frames/beam_window.h"

#include <cmath>

namespace lidard {

BeamWindow beams_between(double angle, double step, std::size_t beams, std::optional<double> lowest,
                         std::optional<double> highest) {
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
