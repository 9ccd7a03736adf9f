// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/merge_sources.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <utility>

namespace lidard {
namespace {

constexpr Span another_clock = std::chrono::seconds(10);

/// A stamp that shows a frame's age. Stamps that are far from the time at hand are of another clock, a bag's
/// or a simulator's: then the arrival counts.
Stamp comparable(Stamp stamp, Stamp now) {
  return now - stamp > another_clock || stamp - now > another_clock ? now : stamp;
}

}  // namespace

MergeSources::MergeSources(Settings settings, const OutputContext& context)
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
  gate_.left_out("on_missing_motion: drop, and poses of the vehicle are missing");
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

void MergeSources::describe(DiagnosticItem& item, Stamp now, bool starting) const {
  describe_states(item, now, starting);
  describe_motion(item);
  item.add("Sources waited for in vain", scheduler_.deadlines_missed());
  if (counters.published == 0 && !gate_.trouble().empty()) item.message = "no output: " + gate_.trouble();
}

void MergeSources::describe_states(DiagnosticItem& item, Stamp now, bool starting) const {
  std::string silent, lost, remedy;
  // Whether any source delivers, and whether all that are lost have never come.
  bool delivers = false, awaited = true;
  for (std::size_t s = 0; s < settings_.names.size(); ++s) {
    const std::string& name = settings_.names[s];
    const SourceState state = scheduler_.state(s, now);
    std::string text = to_string(state);
    const double period = scheduler_.period(s), age_ms = seconds(scheduler_.age(s, now)) * 1000;
    if (state != SourceState::never)
      text += fmt::format(", {:.1f} Hz, age {:.0f} ms", period > 0 ? 1 / period : 0, age_ms);
    item.add("Source " + name, text);
    const SourceState seen = reported_[s];
    std::string& list = seen == SourceState::stale ? silent : lost;
    if (seen != SourceState::ok) list += (list.empty() ? "" : ", ") + name;
    // Not of a source that follows another clock.
    constexpr double longest_said_s = 1, room_s = 0.02;
    const double late = scheduler_.lateness(s);
    if (seen == SourceState::stale && late > 0 && late < longest_said_s)
      remedy = fmt::format("; a deadline of {:.2f} waits for them", late + room_s);
    delivers = delivers || seen == SourceState::ok;
    awaited = awaited && seen != SourceState::lost;
  }
  item.add("Sources lost", lost);
  if (starting || item.health != Health::ok) return;
  if (apart_ > another_clock)
    item.set(Health::warn, fmt::format("merges scans whose stamps are {:.0f} s apart; let all sources follow "
                                       "one clock, a simulator's (/use_sim_time) or this computer's",
                                       seconds(apart_)));
  if (lost.empty() && silent.empty()) return;
  item.set(lost.empty() ? Health::warn : Health::error,
           "publishing without " + (lost.empty() ? silent + ", whose sweeps are too old" + remedy : lost));
  if (!delivers) item.message = "no output, since no source delivers: see the state of its sensors";
  item.awaited = awaited;
  if (counters.no_pose > 0 && !counters.why_no_pose.empty()) item.message += ": " + counters.why_no_pose;
}

void MergeSources::describe_motion(DiagnosticItem& item) const {
  if (poses_.track() == nullptr) return;
  const auto has = [this](SourceUse use) { return std::count(uses_.begin(), uses_.end(), use) > 0; };
  item.add("Motion", poses_.track()->empty()        ? "no poses yet"
                     : has(SourceUse::static_poses) ? "not deskewed: poses of the sweeps' time are missing"
                     : has(SourceUse::extrapolated) ? "deskewed, partly beyond the newest pose"
                                                    : "deskewed");
  gate_.describe(item);
}

}  // namespace lidard
