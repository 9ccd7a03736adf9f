// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/merging_maker.h"

#include <algorithm>
#include <utility>

namespace lidard {
namespace {

/// A stamp that shows a frame's age. Stamps that are far from the time at hand are of another clock, a bag's
/// or a simulator's: then the arrival counts.
Stamp comparable(Stamp stamp, Stamp now) {
  return now - stamp > another_clock || stamp - now > another_clock ? now : stamp;
}

}  // namespace

MergingMaker::MergingMaker(MakerId made, std::vector<std::string> made_of, Settings settings,
                           const PipelineContext& context)
    : Maker(std::move(made), std::move(made_of), context),
      settings_(std::move(settings)),
      scheduler_(sources.size(), settings_.schedule),
      times_(sources.size()),
      reported_(sources.size(), SourceState::never) {
  const ScheduleSettings& schedule = settings_.schedule;
  if (schedule.policy == Policy::rate)
    counters_.most_silence = std::max(counters_.most_silence, 1.5 / schedule.rate);
}

void MergingMaker::delivered(std::size_t source, const SweepTimes& times, double period, Stamp now,
                             bool is_kept) {
  // As in Merger::add().
  if (times_[source] && times.first + restart_limit < times_[source]->first)
    times_.assign(times_.size(), std::nullopt);
  times_[source] = is_kept ? std::optional(times) : std::nullopt;
  scheduler_.delivered(source, comparable(times.last(), now), period, now);
  advance(now);
}

bool MergingMaker::lacks_frames(Stamp now) const {
  for (std::size_t s = 0; s < times_.size(); ++s) {
    if (scheduler_.state(s, now) == SourceState::ok && !times_[s]) return true;
  }
  return false;
}

std::optional<MergeMoment> MergingMaker::due(Stamp now) {
  if (!scheduler_.is_due(now) || lacks_frames(now)) {
    due_since_.reset();
    return std::nullopt;
  }
  MergeMoment moment = moment_of(now);
  if (!due_since_) due_since_ = now;
  const bool lacks_poses = settings_.on_missing_motion != MissingMotion::stand && !has_poses(moment, now);
  const bool drops = settings_.on_missing_motion == MissingMotion::drop;
  if (lacks_poses && !drops && PoseGate::may_wait(*due_since_, scheduler_.deadline(), now))
    return std::nullopt;
  due_since_.reset();
  if (!lacks_poses || !drops) {
    // What is held back waits for the next sweep, whichever source it comes from.
    const bool was_held_back = std::exchange(is_held_back_, !advances(moment.at, last_instant_));
    if (is_held_back_ && !was_held_back) ++counters_.held_back;
    if (is_held_back_) return std::nullopt;
    last_instant_ = moment.at;
    return moment;
  }
  gate_.left_out();
  not_published(now);
  return std::nullopt;
}

/// The instant that the beams are brought to.
MergeMoment MergingMaker::moment_of(Stamp now) {
  MergeMoment moment;
  const std::vector<char>& use = scheduler_.usable(now);
  std::optional<Stamp> first, newest, oldest;
  for (std::size_t s = 0; s < use.size(); ++s) {
    const auto& times = times_[s];
    if (use[s] == 0 || !times) continue;
    first = std::max(first.value_or(times->first), times->first);
    newest = std::max(newest.value_or(times->last()), times->last());
    oldest = std::min(oldest.value_or(times->first), times->first);
  }
  apart_ = first ? *first - *oldest : Span(0);
  const PoseTrack* const track = context_.motion.track();
  moment.at = first.value_or(now);
  if (newest && track != nullptr && !track->empty()) {
    // A transform to the odometry frame exists for stamps up to the newest pose.
    moment.at = settings_.schedule.policy == Policy::rate ? now : *newest;
    moment.at = std::max(*first, std::min(moment.at, track->newest()));
    moment.track = track;
  }
  if (moment.track != nullptr && !find_pose(settings_.destination_frame, context_.vehicle.base_frame,
                                            moment.at, moment.output_from_base))
    moment.track = nullptr;
  return moment;
}

/// True if the way of the vehicle is known for all frames of an output, or nobody knows how it moves.
bool MergingMaker::has_poses(const MergeMoment& moment, Stamp now) {
  if (context_.motion.track() == nullptr) return true;
  const std::vector<char>& use = scheduler_.usable(now);
  for (std::size_t s = 0; s < use.size(); ++s) {
    if (use[s] == 0) continue;
    const bool known = moment.track != nullptr && times_[s] &&
                       moment.track->covers(times_[s]->first, times_[s]->last()) &&
                       moment.track->covers(moment.at, moment.at);
    if (!known) return false;
  }
  return true;
}

void MergingMaker::published(const MergeReport& report, Stamp now) {
  skipped(now);
  uses_ = report.sources;
  const bool stands = std::count(uses_.begin(), uses_.end(), SourceUse::static_poses) > 0;
  gate_.published(context_.motion.track() == nullptr || !stands);
}

void MergingMaker::forget() {
  times_.assign(times_.size(), std::nullopt);
  due_since_.reset();
  uses_.clear();
}

void MergingMaker::restart() {
  times_.assign(times_.size(), std::nullopt);
  scheduler_.reset();
  last_instant_ = {};
  due_since_.reset();
}

std::optional<Stamp> MergingMaker::next_event() const {
  const auto event = scheduler_.next_event();
  if (!due_since_) return event;
  const Stamp given_up = *due_since_ + scheduler_.deadline();
  return event ? std::min(*event, given_up) : given_up;
}

bool MergingMaker::states_changed(Stamp now) {
  bool changed = false;
  for (std::size_t s = 0; s < reported_.size(); ++s) {
    const SourceState state = scheduler_.lasting_state(s, now);
    changed = std::exchange(reported_[s], state) != state || changed;
  }
  return changed;
}

MakerStatus MergingMaker::status(Stamp now) const {
  MakerStatus status = Maker::status(now);
  MergeStatus& merge = status.merge.emplace();
  for (std::size_t s = 0; s < sources.size(); ++s)
    merge.sources.push_back({sources[s], scheduler_.state(s, now), reported_[s], scheduler_.period(s),
                             seconds(scheduler_.age(s, now)), scheduler_.lateness(s)});
  merge.uses = uses_;
  merge.apart = apart_;
  merge.deadlines_missed = scheduler_.deadlines_missed();
  merge.track = context_.motion.track();
  merge.gate = gate_;
  return status;
}

}  // namespace lidard
