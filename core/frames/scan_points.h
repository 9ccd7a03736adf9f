// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <vector>

#include "core/frames/cloud.h"
#include "core/frames/scan.h"

namespace lidard {

/// Appends the returns of a scan, beam by beam with all echoes, as points of its plane (z and ring 0).
inline void append_points(const PlanarScan& scan, std::vector<CloudPoint>& points) {
  for (std::size_t beam = 0; beam < scan.beams; ++beam) {
    for (std::size_t echo = 0; echo < scan.echoes; ++echo) {
      const std::size_t i = scan.index(beam, echo);
      if (scan.statuses[i] != BeamStatus::hit) continue;
      CloudPoint& point = points.emplace_back();
      point.x = scan.ranges[i] * std::cos(scan.angle(beam));
      point.y = scan.ranges[i] * std::sin(scan.angle(beam));
      if (!scan.intensities.empty()) point.intensity = scan.intensities[i];
      point.time = scan.time_increment * static_cast<float>(beam);
    }
  }
}

}  // namespace lidard
