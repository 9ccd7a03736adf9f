// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/merge/merger.h"
#include "core/merge/scheduler.h"
#include "core/motion/pose_gate.h"
#include "daemon/pipeline/maker.h"

namespace lidard {

/// A maker that merges its sources: whether they deliver, when a merge is due and which instant it shows.
class MergingMaker : public Maker {
 public:
  void advance(Stamp now) final {
    if (const auto moment = due(now)) publish(*moment, now);
  }
  std::optional<Stamp> next_event() const final;
  bool states_changed(Stamp now) final;
  void restart() override;
  MakerStatus status(Stamp now) const override;

 protected:
  struct Settings {
    ScheduleSettings schedule;
    MissingMotion on_missing_motion;
    std::string destination_frame;
  };
  MergingMaker(MakerId made, std::vector<std::string> made_of, Settings settings,
               const PipelineContext& context);

  /// Makes the merge of an instant, and calls published(), skipped() or not_published().
  virtual void publish(MergeMoment moment, Stamp now) = 0;
  /// A frame with a pose came in; `is_kept`: and will be used. Publishes what is due now.
  void delivered(std::size_t source, const SweepTimes& times, double period, Stamp now, bool is_kept = true);
  /// Which sources are to be used in the merge, [source].
  const std::vector<char>& usable(Stamp now) { return scheduler_.usable(now); }
  /// The merge was made; it was not, since nobody wants it; or since its pose is not known.
  void published(const MergeReport& report, Stamp now);
  void skipped(Stamp now) {
    scheduler_.done(now);
    count_published(now);
  }
  void not_published(Stamp now) { scheduler_.done(now, true); }
  /// The frames are no longer there: nothing is due until all sources that are well have delivered again.
  void forget();
  /// What became of the sources in the last merge.
  const std::vector<SourceUse>& uses() const { return uses_; }

 private:
  std::optional<MergeMoment> due(Stamp now);
  bool lacks_frames(Stamp now) const;
  MergeMoment moment_of(Stamp now);
  bool has_poses(const MergeMoment& moment, Stamp now);

  Settings settings_;
  Scheduler scheduler_;
  std::vector<std::optional<SweepTimes>> times_;  // of the newest frame of each source
  std::vector<SourceState> reported_;
  std::vector<SourceUse> uses_;
  Stamp last_instant_{};
  Span apart_{0};  // between the sources of the newest merge
  PoseGate gate_;
  std::optional<Stamp> due_since_;  // a merge that waits for poses
  bool is_held_back_ = false;       // the merge that is due shows no newer instant than the last one
};

}  // namespace lidard
