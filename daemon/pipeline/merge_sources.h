// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/merge/merger.h"
#include "core/merge/scheduler.h"
#include "daemon/pipeline/maker.h"
#include "daemon/pipeline/pose_gate.h"

namespace lidard {

/// The sources of an output that merges: whether they deliver, when the output is due and which instant it
/// shows.
class MergeSources {
 public:
  struct Settings {
    std::vector<std::string> names;
    ScheduleSettings schedule;
    MissingMotion on_missing_motion;
    std::string destination_frame;
  };
  /// `context` must outlive this.
  MergeSources(Settings settings, const MakerContext& context);

  /// A frame with a place came in; `is_kept`: and will be used.
  void delivered(std::size_t source, const SweepTimes& times, double period, Stamp now, bool is_kept = true);
  /// The instant of an output that is to be made now.
  std::optional<MergeMoment> due(Stamp now);
  /// Which sources are to be used in it, [source].
  const std::vector<char>& usable(Stamp now) { return scheduler_.usable(now); }
  /// The output was made; it was not, since nobody wants it; or since its place is not known.
  void published(const MergeReport& report, Stamp now);
  void skipped(Stamp now);
  void not_published(Stamp now) { scheduler_.done(now); }
  /// The frames are no longer there: nothing is due until all sources that are well have delivered again.
  void forget();
  /// The input starts again.
  void restart();

  std::optional<Stamp> next_event() const;
  bool states_changed(Stamp now);
  /// What became of the sources in the last output.
  const std::vector<SourceUse>& uses() const { return uses_; }
  MergeStatus status(Stamp now) const;

  MakerCounters counters;

 private:
  bool lacks_frames(Stamp now) const;
  SourceState reported_state(std::size_t source, Stamp now) const;
  MergeMoment moment_of(Stamp now);
  bool has_poses(const MergeMoment& moment, Stamp now);

  Settings settings_;
  const MakerContext& context_;
  const FrameTree& poses_;
  Scheduler scheduler_;
  std::vector<std::optional<SweepTimes>> times_;  // of the newest frame of each source
  std::vector<SourceState> reported_;
  std::vector<unsigned> outputs_without_;  // since the last one with the source
  std::vector<SourceUse> uses_;
  Stamp last_instant_{};
  Span apart_{0};  // between the sources of the newest output
  PoseGate gate_;
  std::optional<Stamp> due_since_;  // an output that waits for poses
  bool is_held_back_ = false;       // the output that is due shows no newer instant than the last one
};

}  // namespace lidard
