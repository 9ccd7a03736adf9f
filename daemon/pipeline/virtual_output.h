// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/base/steady_stamps.h"
#include "core/motion/cloud_motion.h"
#include "core/virtual/virtualizer.h"
#include "daemon/config/config.h"
#include "daemon/pipeline/frame_tree.h"
#include "daemon/pipeline/output_parts.h"
#include "daemon/pipeline/sink.h"

namespace lidard {

/// The virtual scans of one cloud.
class VirtualOutput {
 public:
  /// `topics`: all of the configuration.
  VirtualOutput(const VirtualScanConfig& config, const VehicleConfig& vehicle,
                const std::vector<OutputTopic>& topics, const FrameTree& poses);

  const std::string& cloud_sensor() const { return config_.cloud_topic; }
  void add(const Cloud& cloud, Stamp now, FrameSink& sink);
  bool publishes(const std::string& topic) const;
  /// Why nothing was published on `topic`; empty: all that could be was. `why_silent` says why a sensor gave
  /// no clouds.
  std::string why_missing(const std::string& topic,
                          const std::function<std::string(const std::string& sensor)>& why_silent) const;
  DiagnosticItem diagnostics(Stamp now, bool starting) const;
  const VirtualScanConfig& config() const { return config_; }
  /// Takes the place of an output with another grid.
  void continue_from(const VirtualOutput& before) {
    counters_ = before.counters_;
    stamps_ = before.stamps_;
    why_unplaced_ = before.why_unplaced_;
  }

 private:
  bool place_vehicle(const Cloud& cloud, Pose& vehicle_from_cloud);
  /// Takes the cloud; returns the instant that its scans show.
  Stamp take(const Cloud& cloud, const Pose& vehicle_from_cloud);
  /// The scans of one of the frames.
  void publish(std::size_t frame, Stamp stamp, Stamp now, FrameSink& sink);
  bool carries(const std::string& topic, const std::string& frame) const;
  void describe_frames(DiagnosticItem& item) const;
  void describe_motion(DiagnosticItem& item) const;
  void describe_beams(DiagnosticItem& item) const;

  VirtualScanConfig config_;
  std::string base_frame_;
  bool needs_vehicle_;  // the cloud's place on the vehicle
  const FrameTree& poses_;
  Virtualizer virtualizer_;
  CloudMotion motion_;
  std::vector<PlanarScan> scans_;  // the first is the entry's own, then those of `also`
  std::vector<VirtualScan> outputs_;
  std::vector<std::vector<const OutputTopic*>> topics_;  // of scans_, for each frame
  std::vector<SteadyStamps> stamps_;                     // one for all where the frames share a topic
  std::vector<std::string>
      why_unplaced_;  // why the newest cloud could not be seen from a frame; empty: it could
  OutputCounters counters_;
  std::uint64_t without_rings_ = 0;   // clouds that are points alone
  std::uint64_t without_motion_ = 0;  // clouds that could not be deskewed
  bool stands_ = false;               // the newest one among them
};

}  // namespace lidard
