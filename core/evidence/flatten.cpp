// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/evidence/flatten.h"

#include <algorithm>
#include <cmath>

namespace lidard {

void Flattener::begin(PlanarScan& scan, bool with_intensities) {
  grid_.prepare(scan, with_intensities);
  std::fill(scan.ranges.begin(), scan.ranges.end(), range_without_hit(BeamStatus::none));
  std::fill(scan.statuses.begin(), scan.statuses.end(), BeamStatus::none);
  scan_ = &scan;
}

void Flattener::add(const Eigen::Vector3d& point, float intensity) {
  if (!(point.z() >= band_.min && point.z() <= band_.max)) return;
  const auto range = static_cast<float>(std::hypot(point.x(), point.y()));
  if (!(range >= scan_->range_min && range <= scan_->range_max)) return;
  if (is_own(point)) return;
  const std::size_t beam = grid_.nearest(std::atan2(point.y(), point.x()));
  if (beam >= grid_.beams || !(range < scan_->ranges[beam])) return;
  scan_->set_hit(beam, range);
  if (!scan_->intensities.empty()) scan_->intensities[beam] = intensity;
}

}  // namespace lidard
