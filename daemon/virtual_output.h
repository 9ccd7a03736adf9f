// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>

#include "core/virtualizer.h"
#include "daemon/config.h"
#include "daemon/output_parts.h"
#include "daemon/pose_book.h"
#include "daemon/sink.h"

namespace lidard {

/// The virtual scans of one cloud.
class VirtualOutput {
 public:
  VirtualOutput(const VirtualScanConfig& config, const VehicleConfig& vehicle, const PoseBook& poses);

  const std::string& cloud_sensor() const { return config_.cloud_topic; }
  void add(const Cloud& cloud, Stamp now, FrameSink& sink);
  DiagnosticItem diagnostics(Stamp now) const;
  const VirtualScanConfig& config() const { return config_; }
  /// Takes the place of an output with another grid.
  void continue_from(const VirtualOutput& before) {
    counters_ = before.counters_;
    last_stamps_ = before.last_stamps_;
  }

 private:
  const std::string& topic_of(const std::string& frame) const;

  VirtualScanConfig config_;
  std::string base_frame_;
  Footprint footprint_;  // in base_frame, with its margin
  const PoseBook& poses_;
  Virtualizer virtualizer_;
  PlanarScan scan_;
  std::map<std::string, Stamp> last_stamps_;  // by topic
  OutputCounters counters_;
};

}  // namespace lidard
