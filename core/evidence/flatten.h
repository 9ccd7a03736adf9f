// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>

#include "core/base/pose.h"
#include "core/evidence/beam_rays.h"
#include "core/frames/scan_grid.h"

namespace lidard {

/// Projects points on the xy plane of an output scan and keeps the nearest one per beam: what ira_laser_tools
/// publishes, but rounded to the nearest beam's centre, with the right number of beams and a height rule.
/// Knows neither surfaces nor free space: a beam without a point says "nothing there".
class Flattener {
 public:
  Flattener(const ScanGrid& grid, HeightBand band) : grid_(grid), band_(band) {}

  /// Starts a scan: every beam `none`.
  void begin(PlanarScan& scan, bool with_intensities) {
    grid_.prepare(scan, with_intensities);
    std::fill(scan.ranges.begin(), scan.ranges.end(), range_without_hit(BeamStatus::none));
    std::fill(scan.statuses.begin(), scan.statuses.end(), BeamStatus::none);
    scan_ = &scan;
  }
  /// One point in the output frame, m. Points outside the band, the ranges or the span, or not finite, are
  /// left out.
  void add(const Eigen::Vector3d& point, float intensity) {
    if (!(point.z() >= band_.min && point.z() <= band_.max)) return;
    const auto range = static_cast<float>(std::hypot(point.x(), point.y()));
    if (!(range >= scan_->range_min && range <= scan_->range_max)) return;
    if (is_own(point)) return;
    const std::size_t beam = grid_.nearest(std::atan2(point.y(), point.x()));
    if (beam >= grid_.beams || !(range < scan_->ranges[beam])) return;
    scan_->set_hit(beam, range);
    if (!scan_->intensities.empty()) scan_->intensities[beam] = intensity;
  }

  /// Points inside the vehicle's outline (in the output frame) are left out.
  void set_footprint(const Footprint& footprint) { own_ = footprint; }

  bool is_own(const Eigen::Vector3d& point) const { return own_.contains(point.head<2>()); }

  const ScanGrid& grid() const { return grid_; }

 private:
  ScanGrid grid_;
  HeightBand band_;
  Footprint own_;
  PlanarScan* scan_ = nullptr;
};

}  // namespace lidard
