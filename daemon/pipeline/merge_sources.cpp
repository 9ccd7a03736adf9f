// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/merge_sources.h"

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

MergeSources::MergeSources(Settings settings, const MakerContext& context)
    : settings_(std::move(settings)),
      context_(context),
      poses_(context.poses),
      scheduler_(settings_.names.size(), settings_.schedule),
      times_(settings_.names.size()),
      reported_(settings_.names.size(), SourceState::never),
      outputs_without_(settings_.names.size()) {
  const ScheduleSettings& schedule = settings_.schedule;
  if (schedule.policy == Policy::rate)
    counters.most_silence = std::max(counters.most_silence, 1.5 / schedule.rate);
}

void MergeSources::delivered(std::size_t source, const SweepTimes& times, double period, Stamp now,
                             bool is_kept) {
  // As in Merger::add().
  if (times_[source] && times.first + restart_limit < times_[source]->first)
    times_.assign(times_.size(), std::nullopt);
  times_[source] = is_kept ? std::optional(times) : std::nullopt;
  scheduler_.delivered(source, comparable(times.last(), now), period, now);
}

bool MergeSources::lacks_frames(Stamp now) const {
  for (std::size_t s = 0; s < times_.size(); ++s) {
    if (scheduler_.state(s, now) == SourceState::ok && !times_[s]) return true;
  }
  return false;
}

std::optional<MergeMoment> MergeSources::due(Stamp now) {
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
    if (is_held_back_ && !was_held_back) ++counters.held_back;
    if (is_held_back_) return std::nullopt;
    last_instant_ = moment.at;
    return moment;
  }
  gate_.left_out();
  scheduler_.done(now);
  return std::nullopt;
}

/// The instant that the beams are brought to.
MergeMoment MergeSources::moment_of(Stamp now) {
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
  const PoseTrack* const track = poses_.track();
  moment.at = first.value_or(now);
  if (newest && track != nullptr && !track->empty()) {
    // A transform to the odometry frame exists for stamps up to the newest pose.
    moment.at = settings_.schedule.policy == Policy::rate ? now : *newest;
    moment.at = std::max(*first, std::min(moment.at, track->newest()));
    moment.track = track;
  }
  if (moment.track != nullptr && !poses_.find(settings_.destination_frame, context_.vehicle.base_frame,
                                              moment.at, moment.output_from_base, counters.why_no_pose))
    moment.track = nullptr;
  return moment;
}

/// True if the way of the vehicle is known for all frames of an output, or nobody knows how it moves.
bool MergeSources::has_poses(const MergeMoment& moment, Stamp now) {
  if (poses_.track() == nullptr) return true;
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

void MergeSources::published(const MergeReport& report, Stamp now) {
  skipped(now);
  uses_ = report.sources;
  const bool stands = std::count(uses_.begin(), uses_.end(), SourceUse::static_poses) > 0;
  gate_.published(poses_.track() == nullptr || !stands);
}

void MergeSources::skipped(Stamp now) {
  const std::vector<char>& use = scheduler_.usable(now);
  for (std::size_t s = 0; s < use.size(); ++s)
    outputs_without_[s] = use[s] != 0 ? 0 : outputs_without_[s] + 1;
  scheduler_.done(now);
  ++counters.published;
  counters.last_published = now;
}

void MergeSources::forget() {
  times_.assign(times_.size(), std::nullopt);
  due_since_.reset();
  uses_.clear();
}

void MergeSources::restart() {
  times_.assign(times_.size(), std::nullopt);
  scheduler_.reset();
  last_instant_ = {};
  due_since_.reset();
}

std::optional<Stamp> MergeSources::next_event() const {
  const auto event = scheduler_.next_event();
  if (!due_since_) return event;
  const Stamp given_up = *due_since_ + scheduler_.deadline();
  return event ? std::min(*event, given_up) : given_up;
}

/// A busy computer makes sweeps stale now and then for milliseconds: a source counts as stale after ten
/// outputs without it.
SourceState MergeSources::reported_state(std::size_t source, Stamp now) const {
  constexpr unsigned many_outputs = 10;
  const SourceState state = scheduler_.state(source, now);
  if (state == SourceState::never || state == SourceState::lost) return state;
  return outputs_without_[source] < many_outputs ? SourceState::ok : SourceState::stale;
}

bool MergeSources::states_changed(Stamp now) {
  bool changed = false;
  for (std::size_t s = 0; s < reported_.size(); ++s) {
    const SourceState state = reported_state(s, now);
    changed = std::exchange(reported_[s], state) != state || changed;
  }
  return changed;
}

MergeStatus MergeSources::status(Stamp now) const {
  MergeStatus status;
  for (std::size_t s = 0; s < settings_.names.size(); ++s)
    status.sources.push_back({settings_.names[s], scheduler_.state(s, now), reported_[s],
                              scheduler_.period(s), seconds(scheduler_.age(s, now)), scheduler_.lateness(s)});
  status.uses = uses_;
  status.apart = apart_;
  status.deadlines_missed = scheduler_.deadlines_missed();
  status.track = poses_.track();
  status.gate = gate_;
  return status;
}

}  // namespace lidard
