// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "core/motion/frame_motion.h"
#include "core/virtual/virtualizer.h"
#include "daemon/pipeline/output.h"

namespace lidard {

/// The virtual scans of one cloud.
class VirtualOutput final : public Output {
 public:
  VirtualOutput(const VirtualScanConfig& config, const OutputContext& context);

  OutputId id() const override { return {OutputId::Kind::virtual_group, config_.name}; }
  std::vector<std::string> sources() const override { return {config_.cloud_topic}; }
  void add_cloud(const Cloud& cloud, Stamp now) override;
  void set_scan(const OutputScanConfig& wanted) override;
  bool publishes(const std::string& topic) const override;
  std::string why_missing(const std::string& topic, const WhySilent& why_silent) const override;
  DiagnosticItem diagnostics(Stamp now, bool starting) const override;

 private:
  /// Makes what depends on the grid and the profiles.
  void set_up();
  bool place_vehicle(const Cloud& cloud, Pose& vehicle_from_cloud);
  /// Takes the cloud; returns the instant that its scans show.
  Stamp take(const Cloud& cloud, const Pose& vehicle_from_cloud);
  /// The scans of one of the frames.
  void publish(std::size_t frame, Stamp stamp, Stamp now);
  bool carries(const std::string& topic, std::size_t frame) const;
  void describe_frames(DiagnosticItem& item) const;
  void describe_motion(DiagnosticItem& item) const;
  void describe_beams(DiagnosticItem& item) const;

  VirtualScanConfig config_;
  const OutputContext& context_;
  const FrameTree& poses_;
  bool needs_vehicle_ = true;  // the cloud's place on the vehicle
  std::optional<Virtualizer> virtualizer_;
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
