// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "core/evidence/beam_rays.h"
#include "core/evidence/raster.h"

namespace lidard {

/// Projects points on the xy plane of an output scan and keeps the nearest one per beam, as ira_laser_tools
/// does, but rounded to the nearest beam's centre, with the right number of beams and a height rule. It
/// ignores surfaces and free space: a beam without a point reports "nothing there".
class Flattener {
 public:
  Flattener(const ScanGrid& grid, HeightBand band) : raster_(grid), band_(band) {}

  /// Starts a scan: every beam `none`.
  void begin(PlanarScan& scan, bool with_intensities) {
    grid().prepare(scan, with_intensities);
    std::fill(scan.ranges.begin(), scan.ranges.end(), range_without_hit(BeamStatus::none));
    std::fill(scan.statuses.begin(), scan.statuses.end(), BeamStatus::none);
    scan_ = &scan;
    count_ = 0;
  }
  /// Adds a point in the output frame, m. Drops points that are not finite or lie outside the band, the
  /// ranges or the span.
  void add(const Eigen::Vector3d& point, float intensity) {
    if (!(point.z() >= band_.min && point.z() <= band_.max)) return;
    if (is_own(point)) return;
    x_[count_] = point.x();
    y_[count_] = point.y();
    intensity_[count_] = intensity;
    if (++count_ == block) transform();
  }
  /// Ends the scan: writes the points that are still buffered.
  void end() { transform(); }

  /// Drops points inside the vehicle's outline (in the output frame).
  void set_footprint(const Footprint& footprint) { own_ = footprint; }

  bool is_own(const Eigen::Vector3d& point) const { return !own_.empty() && own_.contains(point.head<2>()); }

  const ScanGrid& grid() const { return raster_.grid(); }

 private:
  // Number of directions that are computed at once.
  static constexpr std::size_t block = 64;

  void transform() {
    std::array<float, block> x, y, ranges, beams;
    for (std::size_t i = 0; i < count_; ++i) {
      x[i] = static_cast<float>(x_[i]);
      y[i] = static_cast<float>(y_[i]);
      ranges[i] = std::sqrt(x[i] * x[i] + y[i] * y[i]);
    }
    raster_.positions(x.data(), y.data(), count_, beams.data());
    for (std::size_t i = 0; i < count_; ++i) {
      if (!(ranges[i] >= scan_->range_min && ranges[i] <= scan_->range_max)) continue;
      const std::size_t beam = beam_of(beams[i], x_[i], y_[i]);
      if (beam >= grid().beams || !(ranges[i] < scan_->ranges[beam])) continue;
      scan_->set_hit(beam, ranges[i]);
      if (!scan_->intensities.empty()) scan_->intensities[beam] = intensity_[i];
    }
    count_ = 0;
  }
  /// The beam nearest to a point at float position `at` (beams from the first one); grid().beams: outside the
  /// span. Near a border between two beams the result is computed in double.
  std::size_t beam_of(float at, double x, double y) const {
    // Five times the rounding error of float.
    const float slack = 1e-6F * raster_.turn();
    // NOLINTNEXTLINE(bugprone-incorrect-roundings): a result that rounding could change is not sure.
    const auto beam = static_cast<std::size_t>(at + 0.5F);
    const bool sure = std::fabs(at - static_cast<float>(beam)) < 0.5F - slack;
    // The first beam also covers the half beam before it.
    if (sure && (beam < grid().beams || at + 1 < raster_.turn())) return beam;
    return grid().nearest(std::atan2(y, x));
  }

  Raster raster_;
  HeightBand band_;
  Footprint own_;
  PlanarScan* scan_ = nullptr;
  // Buffered points.
  std::array<double, block> x_{}, y_{};
  std::array<float, block> intensity_{};
  std::size_t count_ = 0;
};

}  // namespace lidard
