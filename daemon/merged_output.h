// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/merger.h"
#include "daemon/config.h"
#include "daemon/output_parts.h"
#include "daemon/pose_book.h"
#include "daemon/sink.h"

namespace lidard {

/// A merged scan: takes the scans of its sources, publishes when one is due.
class MergedOutput {
 public:
  MergedOutput(const MergedScanConfig& config, const VehicleConfig& vehicle, const PoseBook& poses);

  /// Index of a sensor among the sources, or -1.
  int source_index(const std::string& sensor) const;
  void add(std::size_t source, const PlanarScan& scan, Stamp now, FrameSink& sink);
  DiagnosticItem diagnostics(Stamp now) const;
  void restart() { merger_.reset(); }

 private:
  bool place_footprint(Stamp stamp);

  MergedScanConfig config_;
  std::string base_frame_;
  Footprint footprint_;                   // in base_frame
  std::optional<Pose> footprint_placed_;  // base_frame in the output frame when it was last set
  const PoseBook& poses_;
  Merger merger_;
  std::vector<PlanarScan> scans_;  // the first is the entry's own, then those of `also`
  std::vector<MergedScan> merged_;
  Cloud cloud_;
  OutputCounters counters_;
};

}  // namespace lidard
