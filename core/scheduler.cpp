// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/scheduler.h"

#include <algorithm>
#include <cmath>

namespace lidard {
namespace {

constexpr double deadline_share = 0.3;  // of the shortest period
constexpr double age_share = 1.5;       // of the source's period
// Until a period is known: that of a scanner of 10 Hz.
constexpr double usual_period_s = 0.1;
// So far back it is no late packet but a clock that was set, or an input that starts again.
constexpr Span restart_limit = std::chrono::seconds(1);
constexpr double smoothing = 0.2;

}  // namespace

const char* to_string(Policy policy) {
  switch (policy) {
    case Policy::complete:
      return "complete";
    case Policy::rate:
      return "rate";
    case Policy::trigger:
      return "trigger";
  }
  return "";
}

const char* to_string(SourceState state) {
  switch (state) {
    case SourceState::never:
      return "never";
    case SourceState::ok:
      return "ok";
    case SourceState::stale:
      return "stale";
    case SourceState::lost:
      return "lost";
  }
  return "";
}

Scheduler::Scheduler(std::size_t sources, const ScheduleSettings& settings)
    : settings_(settings), sources_(sources), usable_(sources, 0) {}

void Scheduler::reset() {
  sources_.assign(sources_.size(), {});
  now_.reset();
  first_.reset();
  next_tick_.reset();
  last_done_.reset();
}

/// The time only goes forward, but for an input that starts again.
void Scheduler::notice(Stamp now) {
  if (now_ && now + restart_limit < *now_) {
    reset();
    ++restarts_;
  }
  now_ = now_ ? std::max(*now_, now) : now;
}

void Scheduler::delivered(std::size_t index, Stamp end, double period, Stamp now) {
  notice(now);
  if (!first_) first_ = now;
  Source& source = sources_[index];
  if (source.seen) {
    const double measured = seconds(end - source.end);
    // A pause is no period.
    const bool regular = measured > 0 && (source.period == 0 || measured < 3 * source.period);
    if (source.period == 0 && measured > 0)
      source.period = measured;
    else if (regular)
      source.period += smoothing * (measured - source.period);
  } else if (std::isfinite(period) && period > 0) {
    source.period = period;
  }
  source.seen = source.fresh = true;
  source.arrival = now;
  source.end = end;
}

Span Scheduler::max_age(const Source& source) const {
  if (settings_.max_age) return *settings_.max_age;
  const double period = source.period > 0 ? source.period : usual_period_s;
  return std::min(span_from_seconds(age_share * period), settings_.lost_after);
}

Span Scheduler::deadline() const {
  if (settings_.deadline) return *settings_.deadline;
  double shortest = usual_period_s;
  for (const Source& source : sources_) {
    if (source.period > 0) shortest = std::min(shortest, source.period);
  }
  return span_from_seconds(deadline_share * shortest);
}

SourceState Scheduler::state(std::size_t index, Stamp now) const {
  const Source& source = sources_[index];
  if (!source.seen) return SourceState::never;
  // Arrival counts for what is lost: a scanner whose stamps lag is not silent.
  if (now - source.arrival > settings_.lost_after) return SourceState::lost;
  return now - source.end > max_age(source) ? SourceState::stale : SourceState::ok;
}

Stamp Scheduler::patience_end(const Source& source) const {
  // At the start nobody knows when a source would be due.
  if (!source.seen) return *first_ + settings_.lost_after;
  const double period = source.period > 0 ? source.period : usual_period_s;
  return source.arrival + span_from_seconds(period) + deadline();
}

bool Scheduler::all_delivered(Stamp now) {
  bool any = false;
  bool in_vain = false;
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    const Source& source = sources_[s];
    any = any || source.fresh;
    if (source.fresh || state(s, now) == SourceState::lost) continue;
    if (now < patience_end(source)) return false;
    in_vain = in_vain || source.seen;
  }
  if (any && in_vain) ++deadlines_missed_;
  return any;
}

bool Scheduler::anything_usable(Stamp now) const {
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    if (state(s, now) == SourceState::ok) return true;
  }
  return false;
}

Span Scheduler::idle_period() const {
  if (settings_.policy == Policy::rate) return span_from_seconds(1 / settings_.rate);
  double longest = 0;
  for (const Source& source : sources_) longest = std::max(longest, source.period);
  return span_from_seconds(longest > 0 ? longest : usual_period_s);
}

bool Scheduler::is_due(Stamp now) {
  notice(now);
  if (settings_.policy == Policy::rate) {
    if (!next_tick_) next_tick_ = now;
    return now >= *next_tick_ && (settings_.publish_when_empty || anything_usable(now));
  }
  if (!anything_usable(now)) {
    if (!settings_.publish_when_empty) return false;
    return !last_done_ || now - *last_done_ >= idle_period();
  }
  const Source& trigger = sources_[settings_.trigger];
  // Without its trigger the output goes on with what the others deliver.
  if (settings_.policy == Policy::trigger && now < patience_end(trigger)) return trigger.fresh;
  return all_delivered(now);
}

std::optional<Stamp> Scheduler::next_event() const {
  std::optional<Stamp> next;
  const auto consider = [&](Stamp at) {
    if (now_ && at > *now_ && (!next || at < *next)) next = at;
  };
  for (const Source& source : sources_) {
    if (first_) consider(patience_end(source));
    if (!source.seen) continue;
    consider(source.end + max_age(source) + Span(1));
    consider(source.arrival + settings_.lost_after + Span(1));
  }
  if (settings_.policy == Policy::rate && next_tick_) consider(*next_tick_);
  if (settings_.publish_when_empty && last_done_) consider(*last_done_ + idle_period());
  return next;
}

const std::vector<char>& Scheduler::usable(Stamp now) {
  for (std::size_t s = 0; s < sources_.size(); ++s) usable_[s] = state(s, now) == SourceState::ok ? 1 : 0;
  return usable_;
}

void Scheduler::done(Stamp now) {
  for (Source& source : sources_) source.fresh = false;
  last_done_ = now;
  if (settings_.policy != Policy::rate || !next_tick_) return;
  const Span step = idle_period();
  *next_tick_ = *next_tick_ + step;
  // What was missed is not made up for.
  if (*next_tick_ <= now) *next_tick_ = now + step;
}

}  // namespace lidard
