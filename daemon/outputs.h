// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/merger.h"
#include "core/virtualizer.h"
#include "daemon/config.h"
#include "daemon/pose_book.h"
#include "daemon/sink.h"

namespace lidard {

/// What one output did since the start.
struct OutputCounters {
  std::uint64_t published = 0;
  std::uint64_t no_pose = 0;  ///< inputs not used because the pose of a frame was not known
  std::string why_no_pose;    ///< the newest reason
  Stamp last_published{};
};

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

/// The virtual scans of one cloud.
class VirtualOutput {
 public:
  VirtualOutput(const VirtualScanConfig& config, const VehicleConfig& vehicle, const PoseBook& poses);

  const std::string& cloud_sensor() const { return config_.cloud_topic; }
  void add(const Cloud& cloud, Stamp now, FrameSink& sink);
  DiagnosticItem diagnostics(Stamp now) const;

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
