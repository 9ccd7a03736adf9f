// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/merge/scheduler.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace lidard {
namespace {

constexpr double deadline_share = 0.3;  // of the shortest period
// Period assumed until one is measured: a scanner of 10 Hz.
constexpr double usual_period_s = 0.1;
constexpr double smoothing = 0.2;
// A gap of more than this number of periods is a pause; several pauses in a row are a new period.
constexpr double pause_share = 1.5;
constexpr int pauses_to_believe = 3;
// A source is slower than another if its period is longer by this factor; less may be noise.
constexpr double slower = 1.1;
// One of two sweeps is the nearer one if it is so by this share of the period; less would make the choice
// change with the jitter of every sweep.
constexpr double nearer_share = 0.03;

}  // namespace

const char* to_string(Policy policy) {
  constexpr std::array<const char*, 3> names = {"complete", "rate", "trigger"};
  return names.at(static_cast<std::size_t>(policy));
}

const char* to_string(SourceState state) {
  constexpr std::array<const char*, 4> names = {"never", "ok", "stale", "lost"};
  return names.at(static_cast<std::size_t>(state));
}

Scheduler::Scheduler(std::size_t sources, const ScheduleSettings& settings)
    : settings_(settings), sources_(sources), usable_(sources, 0), outputs_without_(sources, 0) {}

void Scheduler::reset() {
  sources_.assign(sources_.size(), {});
  now_.reset();
  first_.reset();
  next_tick_.reset();
}

/// Advances the time; resets if the input starts again.
void Scheduler::advance(Stamp now) {
  if (now_ && now + restart_limit < *now_) {
    reset();
    ++restarts_;
  }
  now_ = now_ ? std::max(*now_, now) : now;
}

void Scheduler::learn_period(Source& source, double measured) {
  if (measured <= 0) return;
  const bool pause = source.period > 0 && measured > pause_share * source.period;
  source.pauses = pause ? source.pauses + 1 : 0;
  if (source.period == 0 || source.pauses >= pauses_to_believe)
    source.period = measured;
  else if (!pause)
    source.period += smoothing * (measured - source.period);
}

void Scheduler::delivered(std::size_t index, Stamp end, double period, Stamp now) {
  advance(now);
  if (!first_) first_ = now;
  Source& source = sources_[index];
  source.back = source.back || state(index, now) == SourceState::lost;
  const double delay = seconds(now - end);
  if (source.seen) {
    learn_period(source, seconds(end - source.end));
    source.delay += smoothing * (delay - source.delay);
  } else {
    constexpr double slowest_s = 1;  // what a message says may be in another unit
    if (std::isfinite(period) && period > 0) source.period = std::min(period, slowest_s);
    source.delay = delay;
  }
  source.seen = source.fresh = true;
  source.arrival = now;
  source.end = end;
}

Span Scheduler::deadline() const {
  if (settings_.deadline) return *settings_.deadline;
  double shortest = 0;
  for (const Source& source : sources_) {
    if (source.period > 0 && (shortest == 0 || source.period < shortest)) shortest = source.period;
  }
  return span_from_seconds(deadline_share * (shortest > 0 ? shortest : usual_period_s));
}

SourceState Scheduler::state(std::size_t index, Stamp now) const {
  const Source& source = sources_[index];
  if (!source.seen) return SourceState::never;
  if (now > lost_after(source)) return SourceState::lost;
  return now > wait_end(source) ? SourceState::stale : SourceState::ok;
}

SourceState Scheduler::lasting_state(std::size_t index, Stamp now) const {
  constexpr unsigned many_outputs = 10;
  const SourceState is = state(index, now);
  if (is == SourceState::never || is == SourceState::lost) return is;
  return outputs_without_[index] < many_outputs ? SourceState::ok : SourceState::stale;
}

Stamp Scheduler::next_arrival(const Source& source) {
  const double period = source.period > 0 ? source.period : usual_period_s;
  // Counted from the stamp, so that a late sweep does not extend the wait for the next one. At most one
  // period of delay is accepted, and so much of a stamp that has jumped ahead.
  const Stamp arrival = source.end + span_from_seconds(std::min(source.delay, period));
  return std::min(arrival, source.arrival + span_from_seconds(period)) + span_from_seconds(period);
}

Stamp Scheduler::wait_end(const Source& source) const {
  // A source that never delivered has no due time.
  return source.seen ? next_arrival(source) + deadline() : *first_ + settings_.lost_after;
}

Stamp Scheduler::lost_after(const Source& source) const {
  // Loss is judged by the arrival: a scanner whose stamps lag is not silent.
  return std::max(source.arrival + settings_.lost_after, wait_end(source));
}

bool Scheduler::is_complete(Stamp now) const {
  const Source* leader = nullptr;
  std::optional<Stamp> newest;
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    const Source& source = sources_[s];
    if (!source.seen && now <= wait_end(source)) return false;
    if (state(s, now) != SourceState::ok) continue;
    newest = std::max(newest.value_or(source.end), source.end);
    // A sweep that missed the last output is no reason for another one.
    const bool leads = leader == nullptr ||
                       (source.used != leader->used ? source.used : source.period > slower * leader->period);
    if (leads) leader = &source;
  }
  if (leader == nullptr || !leader->fresh) return false;
  const Stamp instant = leader->end + (*newest - leader->end) / 2;
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    const bool other = &sources_[s] != leader && state(s, now) == SourceState::ok;
    if (other && next_is_awaited(sources_[s], *leader, instant, now)) return false;
  }
  return true;
}

bool Scheduler::next_is_awaited(const Source& source, const Source& leader, Stamp instant, Stamp now) const {
  if (source.period <= 0) return !source.fresh;
  const Span period = span_from_seconds(source.period);
  const double gain =
      std::abs(seconds(source.end - instant)) - std::abs(seconds(source.end + period - instant));
  const double least = nearer_share * source.period;
  // A sweep is used again only if the next one is farther; before the first output nothing was used.
  if (!source.fresh) return !leader.used || gain > -least;
  if (gain <= least) return false;
  const Stamp next = next_arrival(source), leader_next = next_arrival(leader);
  // The leader's next sweep must not come first: an output would be missing.
  if (next + span_from_seconds(deadline_share * source.period) > leader_next) return false;
  // If the source delivers only once between two sweeps of the leader, the wait changes the pairs once and
  // for all. Otherwise each output would be later.
  return next + period > leader_next || next <= now + deadline();
}

bool Scheduler::anything_usable(Stamp now) const {
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    if (state(s, now) == SourceState::ok) return true;
  }
  return false;
}

bool Scheduler::sources_changed(Stamp now) const {
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    const bool usable = state(s, now) == SourceState::ok;
    if (usable ? sources_[s].back : sources_[s].used) return true;
  }
  return false;
}

bool Scheduler::is_due(Stamp now) {
  advance(now);
  if (settings_.policy == Policy::rate) {
    if (!next_tick_) next_tick_ = now;
    return (now >= *next_tick_ || sources_changed(now)) && anything_usable(now);
  }
  if (!anything_usable(now)) return false;
  if (sources_changed(now)) return true;
  const Source& trigger = sources_[settings_.trigger];
  // If the trigger is overdue, the output continues with the other sources.
  if (settings_.policy == Policy::trigger && now <= wait_end(trigger)) return trigger.fresh;
  return is_complete(now);
}

std::optional<Stamp> Scheduler::next_event() const {
  std::optional<Stamp> next;
  const auto consider = [&](Stamp at) {
    if (now_ && at > *now_ && (!next || at < *next)) next = at;
  };
  for (const Source& source : sources_) {
    if (!first_) break;
    // Until then the source is good: who adds up how long it was stale looks at both.
    consider(wait_end(source));
    consider(wait_end(source) + Span(1));
    if (source.seen) consider(lost_after(source) + Span(1));
  }
  if (settings_.policy == Policy::rate && next_tick_) consider(*next_tick_);
  return next;
}

const std::vector<char>& Scheduler::usable(Stamp now) {
  for (std::size_t s = 0; s < sources_.size(); ++s) usable_[s] = state(s, now) == SourceState::ok ? 1 : 0;
  return usable_;
}

void Scheduler::done(Stamp now, bool is_left_out) {
  bool in_vain = false;
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    const SourceState is = state(s, now);
    sources_[s].fresh = sources_[s].back = false;
    sources_[s].used = is == SourceState::ok;
    if (!is_left_out) outputs_without_[s] = sources_[s].used ? 0 : outputs_without_[s] + 1;
    in_vain = in_vain || is == SourceState::stale;
  }
  if (in_vain) ++deadlines_missed_;
  if (settings_.policy != Policy::rate || !next_tick_) return;
  const Span step = rate_period();
  const bool early = now < *next_tick_;
  *next_tick_ = *next_tick_ + step;
  // Missed outputs are not made up for; an early output restarts the schedule.
  if (early || *next_tick_ <= now) *next_tick_ = now + step;
}

}  // namespace lidard
