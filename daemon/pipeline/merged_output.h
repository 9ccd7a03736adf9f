// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "core/merge/merger.h"
#include "core/merge/mount_check.h"
#include "core/merge/scheduler.h"
#include "daemon/pipeline/output.h"

namespace lidard {

/// A merged scan: takes the scans of its sources, publishes when one is due.
class MergedOutput final : public Output {
 public:
  MergedOutput(const MergedScanConfig& config, const OutputContext& context);

  OutputId id() const override { return {OutputId::Kind::merged, config_.name}; }
  std::vector<std::string> sources() const override { return config_.laserscan_topics; }
  void add_scan(std::size_t source, const PlanarScan& scan, Stamp now) override;
  void advance(Stamp now) override;
  std::optional<Stamp> next_event() const override;
  bool states_changed(Stamp now) override;
  void set_scan(const OutputScanConfig& wanted) override;
  void restart() override;
  bool publishes(const std::string& topic) const override;
  std::string why_missing(const std::string& topic, const WhySilent& why_silent) const override;
  DiagnosticItem diagnostics(Stamp now, bool starting) const override;

 private:
  /// Makes what depends on the grid and the profiles.
  void set_up();
  bool place_footprint(Stamp stamp);
  /// The instant that the beams are brought to.
  MergeMoment moment_of(Stamp now);
  bool lacks_sweeps(Stamp now) const;
  bool must_wait_for_motion(const MergeMoment& moment, Stamp now);
  void publish(MergeMoment moment, Stamp now);
  void fill_status();
  /// Compares what the sources of the output just made see of the same surfaces.
  void compare_sources(Stamp stamp);
  void describe_motion(DiagnosticItem& item) const;
  void describe_sources(DiagnosticItem& item, Stamp now, bool starting) const;
  void describe_beams(DiagnosticItem& item) const;
  void describe_overlap(DiagnosticItem& item) const;

  MergedScanConfig config_;
  const OutputContext& context_;
  const FrameTree& poses_;
  Footprint footprint_;                   // in base_frame
  std::optional<Pose> footprint_placed_;  // base_frame in the output frame when it was last set
  std::optional<Merger> merger_;
  Scheduler scheduler_;
  MountCheck overlap_;
  std::vector<const PlacedScan*> compared_;
  std::vector<Eigen::Vector2d> places_;
  std::vector<SourceState> reported_states_;
  std::vector<std::string> why_unplaced_;  // why the newest scan of a source had no place; empty: it had one
  std::vector<char> taken_;                // sources of which a scan was ever used
  std::vector<PlanarScan> scans_;          // the first is the entry's own, then those of `also`
  std::vector<const OutputTopic*> scan_topics_;  // theirs
  const OutputTopic* cloud_topic_ = nullptr;     // nullptr, as below: none
  const OutputTopic* status_topic_ = nullptr;
  std::vector<MergedScan> merged_;
  PlanarScan status_;
  Cloud cloud_;
  OutputCounters counters_;
  SteadyStamps stamps_;
  std::optional<Stamp> waits_for_motion_since_;
  std::vector<SourceUse> uses_;       // of the last output
  Span latency_{};                    // of the last output: from its instant to its publication
  Span skew_{};                       // between the last rays of the sweeps that it was made of
  std::uint64_t without_motion_ = 0;  // outputs with sources that could not be deskewed
  std::uint64_t dropped_ = 0;         // outputs left out since poses were missing
};

}  // namespace lidard
