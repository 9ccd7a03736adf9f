// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/frames/beam_window.h"
#include "drivers/model.h"

namespace lidard {

/// What every driver holds.
class DriverBase : public Driver {
 public:
  const Counters& counters() const final { return counters_; }
  const DeviceInfo& info() const final { return info_; }

 protected:
  explicit DriverBase(const DriverConfig& config) : config_(config) {
    info_.set("Vendor Name", config.model->vendor);
    info_.set("Product Name", config.model->product);
  }
  /// Details that are listed anew, behind vendor and product.
  void clear_details() { info_.details.resize(2); }

  DriverConfig config_;
  Counters counters_;
  DeviceInfo info_;
};

/// Frame and limits of a planar scanner's scans.
inline void prepare_scan(const DriverConfig& config, PlanarScan& scan) {
  scan.frame_id = config.frame_id;
  scan.range_min = static_cast<float>(config.model->range_min);
  scan.range_max = static_cast<float>(config.model->range_max);
}

/// Gives a scan those of `beams` beams that the configured angles leave, the first of all at `angle` and each
/// `step` further, rad. Returns which they are.
inline BeamWindow choose_beams(const DriverConfig& config, double angle, double step, std::size_t beams,
                               PlanarScan& scan) {
  const BeamWindow kept = beams_between(angle, step, beams, config.angle_min, config.angle_max);
  scan.beams = kept.count;
  scan.set_angles(static_cast<float>(angle + step * static_cast<double>(kept.first)),
                  static_cast<float>(step));
  return kept;
}

}  // namespace lidard
