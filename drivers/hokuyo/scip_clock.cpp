// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/hokuyo/scip_clock.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace lidard::hokuyo {
namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr std::int64_t counter_length = (std::int64_t{1} << 24U) * ms;
/// A counter this far ahead of the elapsed time was reset, or a clock was set.
constexpr std::int64_t jump_limit = 1000 * ms;
/// A counter that lags by less shows a stalled host; TCP keeps the data meanwhile.
constexpr std::int64_t longest_stall = DeviceClock::longest_stall.count();
/// A counter that goes back by more was reset.
constexpr std::int64_t backward_limit = 100 * ms;
/// A sweep this far from the line means that the motor did not turn evenly.
constexpr std::int64_t uneven_limit = 3 * ms / 2;
constexpr std::size_t turns_for_fit = 8;
/// A line is fitted again after so many turns, since the fit is expensive.
constexpr std::int64_t turns_between_fits = 64;
/// A turn that begins that far outside of its tick is not on the line.
constexpr std::int64_t line_tolerance = ms / 10;
/// A wider band of ticks means that the motor changed its speed.
constexpr double widest_band = 1.25e6;
/// A motor's jitter, unverified.
constexpr std::int64_t tick_margin = ms / 20;
/// By so many more pairs of scans it is shown if scans leave on ticks.
constexpr int enough_votes = 3;
constexpr std::int64_t witness_margin = ms / 10;
/// Turns from one witness to the next, at most: the drift between is not known well.
constexpr std::int64_t longest_pair = 40;
constexpr std::size_t first_delay = 16;
/// Comparisons of one row: the clocks drift apart by 0.5 ms then if they differ by 1000 ppm.
constexpr Span comparison_age = std::chrono::milliseconds(500);
/// The line through the arrivals reaches back to a comparison of this age.
constexpr Span drift_age = std::chrono::seconds(25);
/// The least delay is known after this time. A larger change later comes from a slewed host clock; a better
/// line through the turns changes it by less.
constexpr Span delay_age = std::chrono::seconds(6);
constexpr std::int64_t delay_change = ms / 2;
/// Wider bounds come from answers that waited for something.
constexpr std::int64_t coarse_comparison = 3 * ms;
/// A comparison bounds stamps by itself for so long.
constexpr Span bound_age = std::chrono::seconds(2);
/// A longer delay is impossible: the comparison and the sweeps do not fit together.
constexpr std::int64_t longest_delay = 50 * ms;

std::int64_t nanoseconds(ScipStamp stamp) {
  const std::int64_t unit = stamp.microseconds ? 1000 : ms;
  return static_cast<std::int64_t>(stamp.ticks & 0xffffffffffffU) * unit;
}

}  // namespace

void TurnLine::reset() {
  turns_.clear();
  fitted_ = 0;
  uncertainty_ = ms / 2;
}

bool TurnLine::add(Span tick, Span period, Stamp arrival) {
  Turn turn{0, tick.count(), arrival.ns};
  bool even = true;
  skipped_ = 0;
  if (!turns_.empty()) {
    const std::int64_t passed = tick.count() - newest().tick;
    const std::int64_t turns = (passed + period.count() / 2) / period.count();
    turn.number = newest().number + turns;
    even = turns > 0 && std::abs(passed - turns * period.count()) <= std::max(uneven_limit, turns * ms / 4);
    if (turns > 1) skipped_ = turns - 1;
  }
  if (!even) {
    reset();
    turn.number = 0;
  }
  turns_.push_back(turn);
  return even;
}

/// The span of the ticks, measured from a line of that period; `lowest` gets where, relative to the newest
/// tick.
double TurnLine::width(double period, double* lowest) const {
  double low = 0, high = 0;
  for (const Turn& turn : turns_) {
    // From the newest on, so that doubles hold nanoseconds exactly.
    const double above = static_cast<double>(turn.tick - newest().tick) -
                         period * static_cast<double>(turn.number - newest().number);
    low = std::min(low, above);
    high = std::max(high, above);
  }
  if (lowest != nullptr) *lowest = low;
  return high - low;
}

/// The width is a convex function of the period: a search by thirds finds its minimum.
void TurnLine::fit_once() {
  const Turn& oldest = turns_.front();
  const auto turns = static_cast<double>(newest().number - oldest.number);
  const double mean = static_cast<double>(newest().tick - oldest.tick) / turns;
  double low = mean - 2e6 / turns, high = mean + 2e6 / turns;
  constexpr int thirds = 24;  // 4 ms * (2/3)^24 = 0.24 us over all turns
  for (int i = 0; i < thirds; ++i) {
    const double left = low + (high - low) / 3, right = high - (high - low) / 3;
    if (width(left, nullptr) < width(right, nullptr))
      high = right;
    else
      low = left;
  }
  period_ = (low + high) / 2;
}

bool TurnLine::fit() {
  const Turn& turn = newest();
  if (fitted_ > 0) {
    const std::int64_t in_tick = begin(turn.number) - turn.tick;
    const bool off = in_tick < -line_tolerance || in_tick > ms + line_tolerance;
    if (!off && count() < 2 * fitted_ && turn.number - fitted_at_ < turns_between_fits) return false;
  }
  fit_once();
  double lowest = 0, band = width(period_, &lowest);
  while (band > widest_band && count() > turns_for_fit) {
    turns_.erase_begin(count() / 2);
    fit_once();
    band = width(period_, &lowest);
  }
  // A counter reads up to one tick low: use the middle of the possible range.
  base_number_ = turn.number;
  base_ = turn.tick + std::llround(lowest + (band + static_cast<double>(ms)) / 2);
  uncertainty_ = std::max<std::int64_t>(0, std::llround((static_cast<double>(ms) - band) / 2));
  fitted_ = count();
  fitted_at_ = turn.number;
  return true;
}

std::int64_t TurnLine::begin(std::int64_t number) const {
  return base_ + std::llround(period_ * static_cast<double>(number - base_number_));
}

/// The counter without its overflows; starts again where it was reset.
Span ScipClock::unwrap(ScipStamp stamp, Stamp arrival) {
  std::int64_t device = nanoseconds(stamp);
  if (known_) {
    const std::int64_t expected = last_.count() + (arrival - last_arrival_).count();
    if (!stamp.microseconds) {
      const auto turns =
          std::llround(static_cast<double>(expected - device) / static_cast<double>(counter_length));
      device += turns * counter_length;
      if (device / counter_length > last_.count() / counter_length) ++wraps_;
    }
    const bool reset = device < last_.count() - backward_limit;
    if (reset || device - expected > jump_limit || expected - device > longest_stall) {
      ++restarts_;
      clock_.restart();
      // The first sweeps of a stream have not shown the least delay yet.
      if (turns_.count() < first_delay) delay_.reset();
      turns_.reset();
      compared_ = false;
      device = nanoseconds(stamp);
    }
  }
  known_ = true;
  last_ = Span(device);
  last_arrival_ = arrival;
  return last_;
}

void ScipClock::begin_with(const Sweep& sweep) {
  const bool known = known_;
  const Span last = last_;
  const Stamp last_arrival = last_arrival_;
  const Span read = unwrap(sweep.stamp, sweep.arrival);
  clock_.observe(sweep.stamp.microseconds ? read + sweep.until_sent : sent_at(read, sweep), sweep.arrival);
  known_ = known;
  last_ = last;
  last_arrival_ = last_arrival;
}

Stamp ScipClock::begin_of(const Sweep& sweep, std::int64_t& skipped) {
  const Span read = unwrap(sweep.stamp, sweep.arrival);
  skipped = 0;
  if (!sweep.evenly) {
    turns_.reset();
  } else {
    turns_.add(read, sweep.period, sweep.arrival);
    skipped = turns_.skipped();
  }
  if (mode_ == ClockMode::arrival) {
    clock_.observe(read + sweep.until_sent, sweep.arrival);
    return clock_.to_host(read + sweep.until_sent) - sweep.until_sent;
  }
  Span begin = read;
  // Sweeps of one read show the intervals of the counter alone.
  const bool is_first_read = turns_.count() > 0 && turns_.turns().front().arrival == sweep.arrival.ns;
  if (sweep.stamp.microseconds) {
    clock_.observe(begin + sweep.until_sent, sweep.arrival);
  } else if (!sweep.evenly || turns_.count() < turns_for_fit || is_first_read) {
    clock_.observe(sent_at(read, sweep), sweep.arrival);
    const Stamp middle = clock_.to_host(read + Span(ms / 2) + sweep.until_sent);
    learn_delay(sweep.arrival);
    Stamp end = middle;
    if (delay_)
      end = middle - Span(*delay_);
    else if (!clock_.is_held())
      end = std::min(middle, sweep.arrival);
    return as_compared(end - sweep.until_sent, read, sweep);
  } else {
    begin = begin_by_line(sweep, read);
  }
  learn_delay(sweep.arrival);
  const Span sent = begin + sweep.until_sent;
  return as_compared(clock_.to_host(sent) - sweep.until_sent - Span(delay_.value_or(0)), read, sweep);
}

/// Earliest time at which a sweep left: at its end, or on the next tick where the sensor sends on ticks.
Span ScipClock::sent_at(Span begin, const Sweep& sweep) const {
  const std::int64_t ready = (begin + sweep.until_sent).count();
  if (!on_tick_) return Span(ready);
  return Span((ready + ms - 1) / ms * ms);
}

/// Pairs of scans whose arrivals show that scans leave on ticks, less those that show that they leave at
/// once: pairs that differ in the wait for the tick. `processing`: from the end of a sweep until it could
/// leave. A scan ready too near a tick is no witness.
int ScipClock::votes_for_ticks(const Sweep& sweep, std::int64_t processing) const {
  const std::int64_t unsure = 2 * turns_.uncertainty() + witness_margin;
  std::int64_t before = std::numeric_limits<std::int64_t>::min() / 2, late = 0, wait = 0;
  int votes = 0;
  for (const TurnLine::Turn& turn : turns_.turns()) {
    const Span end = Span(turns_.begin(turn.number)) + sweep.until_sent;
    const std::int64_t rest = ms - (end.count() + processing) % ms;
    if (rest < unsure || rest > ms - unsure) continue;
    const std::int64_t waited_more = rest - std::exchange(wait, rest);
    const std::int64_t arrived = turn.arrival - clock_.to_host(end).ns;
    const std::int64_t later = arrived - std::exchange(late, arrived);
    if (turn.number - std::exchange(before, turn.number) > longest_pair) continue;
    const std::int64_t if_on_tick = std::abs(later - waited_more), if_at_once = std::abs(later);
    if (std::abs(if_on_tick - if_at_once) > ms / 2) votes += if_on_tick < if_at_once ? 1 : -1;
  }
  return votes;
}

/// Learns from the turns so far if scans leave on ticks, whatever the time of processing.
void ScipClock::find_tick(const Sweep& sweep) {
  int most = std::numeric_limits<int>::min();
  for (std::int64_t processing = 0; processing < ms; processing += witness_margin)
    most = std::max(most, votes_for_ticks(sweep, processing));
  if (std::abs(most) >= enough_votes) on_tick_ = most > 0;
}

/// Soon after a comparison the comparison alone bounds the begin, however late the first sweeps of a stream
/// were read.
Stamp ScipClock::as_compared(Stamp begin, Span read, const Sweep& sweep) const {
  if (mode_ != ClockMode::smooth || !compared_ || sweep.arrival - compared_at_ > bound_age) return begin;
  constexpr double worst_drift = 1000e-6;
  const std::int64_t tick = sweep.stamp.microseconds ? 0 : ms;
  const auto drifted =
      std::llround(worst_drift * std::abs(static_cast<double>((read - compared_device_).count())));
  return Stamp{std::clamp<std::int64_t>(begin.ns, read.count() + lowest_ - drifted,
                                        read.count() + tick + highest_ + drifted)};
}

/// Begin of the newest turn by the line. A better line is applied to all turns so far again.
Span ScipClock::begin_by_line(const Sweep& sweep, Span read) {
  if (turns_.fit() && !clock_.is_held()) {
    if (may_tick_) find_tick(sweep);
    clock_.restart();
    for (const TurnLine::Turn& turn : turns_.turns()) observe_turn(turn, sweep);
  } else {
    observe_turn(turns_.newest(), sweep);
  }
  const Span begin(turns_.begin(turns_.newest().number));
  return on_tick_ ? std::clamp(begin, read, read + Span(ms)) : begin;
}

void ScipClock::observe_turn(const TurnLine::Turn& turn, const Sweep& sweep) {
  std::int64_t begin = turns_.begin(turn.number);
  // As far as the line is uncertain, the sweep may have ended before a tick.
  if (on_tick_) begin = std::max(turn.tick, begin - 2 * turns_.uncertainty() - tick_margin);
  clock_.observe(sent_at(Span(begin), sweep), Stamp{turn.arrival});
}

/// Measures the delay from the end of a sweep to its arrival, without the network's jitter: the lateness of
/// the line through the arrivals where the clocks were compared.
void ScipClock::learn_delay(Stamp now) {
  if (!compared_ || now - compared_at_ > drift_age) return;
  const std::int64_t compared = lowest_ + (highest_ - lowest_) / 2;
  const std::int64_t offset = clock_.to_host(compared_device_).ns - compared_device_.count();
  const std::int64_t delay = offset - compared;
  if (delay < -ms || delay > longest_delay) return;
  if (now - compared_at_ <= delay_age || !delay_) early_delay_ = delay;
  const std::int64_t likely = std::clamp(delay, early_delay_ - delay_change, early_delay_ + delay_change);
  // Some firmware of a UST answers TM1 on a tick of 5 ms: then the arrivals of scans, which are late by the
  // network's delay alone, say more than the comparisons.
  const bool is_coarse = may_tick_ && highest_ - lowest_ > coarse_comparison;
  delay_ = is_coarse ? 0 : std::max<std::int64_t>(0, likely);
}

bool ScipClock::needs_comparison() const {
  if (mode_ != ClockMode::smooth || !was_compared_ || delay_) return false;
  return !compared_ || (known_ && last_arrival_ - compared_at_ > drift_age);
}

void ScipClock::compare(ScipStamp stamp, Stamp sent, Stamp received) {
  const std::int64_t device = unwrap(stamp, received).count();
  const std::int64_t resolution = stamp.microseconds ? 1000 : ms;
  const std::int64_t low = sent.ns - device - resolution;
  const std::int64_t high = received.ns - device;
  compared_ = compared_ && received - compared_at_ <= comparison_age;
  lowest_ = compared_ ? std::max(lowest_, low) : low;
  highest_ = compared_ ? std::min(highest_, high) : high;
  compared_ = lowest_ <= highest_;
  was_compared_ = true;
  compared_device_ = Span(device);
  compared_at_ = received;
}

std::optional<Span> ScipClock::uncertainty() const {
  if (!compared_) return std::nullopt;
  return Span(highest_ - lowest_);
}

std::optional<Span> ScipClock::measured_delay() const {
  if (!delay_) return std::nullopt;
  return Span(*delay_);
}

void ScipClock::connection() {
  compared_ = was_compared_ = false;
  delay_.reset();
  turns_.reset();
}

void ScipClock::reset() {
  connection();
  on_tick_ = may_tick_;
  clock_.reset();
  known_ = false;
}

}  // namespace lidard::hokuyo
