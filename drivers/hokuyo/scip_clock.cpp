// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/hokuyo/scip_clock.h"

#include <algorithm>
#include <cmath>

namespace lidard::hokuyo {
namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr std::int64_t counter_length = (std::int64_t{1} << 24U) * ms;
/// A counter this far ahead of what the time that passed tells was reset, or a clock was set.
constexpr std::int64_t jump_limit = 1000 * ms;
/// One that goes on but lags by less shows a host that did not look; TCP keeps what came meanwhile.
constexpr std::int64_t longest_stall = 5000 * ms;
/// One that goes back by more was reset.
constexpr std::int64_t backward_limit = 100 * ms;
/// A sweep this far from the line means that the motor did not turn evenly.
constexpr std::int64_t uneven_limit = 3 * ms / 2;
constexpr std::size_t turns_for_fit = 8;
/// Whole ms tell the length of a turn better than the clocks drift (1000 ppm) from so many turns on.
constexpr std::size_t turns_for_motor = 64;
/// A motor that runs off what was taken for its speed by more gets its turn measured again; the line through
/// the arrivals follows less.
constexpr double turn_tolerance = 150e-6;
/// The first sweeps of a stream have not shown the least delay yet.
constexpr std::size_t first_delay = 16;
/// Before the drift is known, the clocks drift apart from the comparison on (1000 ppm make 0.5 ms).
constexpr Span comparison_age = std::chrono::milliseconds(500);
/// The drift is known by then, and the turns since the comparison are still there.
constexpr Span drift_age = std::chrono::seconds(6);
/// Turns that tell the delay: the younger the comparison, the less a wrong drift counts.
constexpr Span turn_age = std::chrono::seconds(2);
/// A way that takes longer is no way: the comparison and the sweeps do not fit together.
constexpr std::int64_t longest_delay = 50 * ms;

std::int64_t nanoseconds(ScipStamp stamp) {
  const std::int64_t unit = stamp.microseconds ? 1000 : ms;
  return static_cast<std::int64_t>(stamp.ticks & 0xffffffffffffU) * unit;
}

}  // namespace

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

void TurnLine::fit(double& period, double& newest_tick) const {
  double sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (const Turn& turn : turns_) {
    // From the newest on, so that doubles hold nanoseconds exactly.
    const auto x = static_cast<double>(turn.number - newest().number);
    const auto y = static_cast<double>(turn.tick - newest().tick);
    sx += x, sy += y, sxx += x * x, sxy += x * y;
  }
  const auto n = static_cast<double>(count());
  const double determinant = n * sxx - sx * sx;
  if (!(determinant > 0)) return;
  period = (n * sxy - sx * sy) / determinant;
  newest_tick = static_cast<double>(newest().tick) + (sy * sxx - sx * sxy) / determinant;
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
    }
    const bool reset = device < last_.count() - backward_limit;
    if (reset || device - expected > jump_limit || expected - device > longest_stall) {
      ++restarts_;
      clock_.reset();
      counter_clock_.reset();
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

Stamp ScipClock::begin_of(const Sweep& sweep, std::int64_t& skipped) {
  const Span read = unwrap(sweep.stamp, sweep.arrival);
  skipped = 0;
  if (!sweep.evenly) {
    turns_.reset();
  } else {
    if (!turns_.add(read, sweep.period, sweep.arrival) || turns_.count() == 1) chosen_at_ = 0;
    skipped = turns_.skipped();
  }
  const Span begin = mode_ == ClockMode::smooth ? device_begin(sweep, read) : read;
  const Span sent = begin + sweep.until_sent;
  clock_.observe(sent, sweep.arrival);
  counter_clock_.observe(read + sweep.until_sent, sweep.arrival);
  if (mode_ == ClockMode::smooth && sweep.evenly) {
    turns_.turns().back().begin = begin.count();
    learn_delay(sweep);
  }
  return as_compared(clock_.to_host(sent) - sweep.until_sent - Span(delay_.value_or(0)), read, sweep);
}

/// Next to a comparison that alone bounds when the counter showed what it did, however late the first sweeps
/// of a stream were taken.
Stamp ScipClock::as_compared(Stamp begin, Span read, const Sweep& sweep) const {
  if (mode_ != ClockMode::smooth || !compared_ || sweep.arrival - compared_at_ > turn_age) return begin;
  constexpr double worst_drift = 1000e-6;
  const std::int64_t tick = sweep.stamp.microseconds ? 0 : ms;
  const auto drifted =
      std::llround(worst_drift * std::abs(static_cast<double>((read - compared_device_).count())));
  return Stamp{std::clamp<std::int64_t>(begin.ns, read.count() + lowest_ - drifted,
                                        read.count() + tick + highest_ + drifted)};
}

Span ScipClock::device_begin(const Sweep& sweep, Span read) {
  if (sweep.stamp.microseconds) return read;
  if (!sweep.evenly || turns_.count() < turns_for_fit) return read + Span(ms / 2);
  if (!on_tick_) return turns_.count() < turns_for_motor ? read + Span(ms / 2) : by_motor(sweep);
  double period = 0, newest = 0;
  turns_.fit(period, newest);
  return Span(std::clamp<std::int64_t>(std::llround(newest) + ms / 2, read.count(), read.count() + ms));
}

/// Time of the newest turn as the motor tells it. When a better length of a turn is known, what was seen so
/// far is seen again with it.
Span ScipClock::by_motor(const Sweep& sweep) {
  const auto begin = [this](const TurnLine::Turn& turn) {
    return Span(base_ + std::llround(turn_ * static_cast<double>(turn.number)));
  };
  double period = turn_, newest = 0;
  const std::size_t count = turns_.count();
  if (chosen_at_ == 0 || count >= 2 * chosen_at_ || turns_.newest().number % 64 == 0) {
    turns_.fit(period, newest);
    const bool better = chosen_at_ == 0 || count >= 2 * chosen_at_;
    if (better || std::abs(period - turn_) > turn_ * turn_tolerance) {
      turn_ = period;
      chosen_at_ = count;
      base_ = std::llround(newest - period * static_cast<double>(turns_.newest().number)) + ms / 2;
      clock_.reset();
      for (TurnLine::Turn& turn : turns_.turns()) {
        turn.begin = begin(turn).count();
        clock_.observe(Span(turn.begin) + sweep.until_sent, Stamp{turn.arrival});
      }
    }
  }
  return begin(turns_.newest());
}

/// From the end of a sweep to its arrival, without the network's jitter. The counter shows the sweep's begin
/// but for a fraction of a tick, so each sweep bounds it from both sides.
void ScipClock::learn_delay(const Sweep& sweep) {
  if (!compared_) return;
  const Span age = sweep.arrival - compared_at_;
  const bool young = turns_.count() >= first_delay && age <= comparison_age;
  const bool knows_drift = counter_clock_.knows_drift();
  if (!young && !(knows_drift && age <= drift_age)) return;
  const double drift = knows_drift ? counter_clock_.drift_ppm() * 1e-6 : 0;
  const std::int64_t compared = lowest_ + (highest_ - lowest_) / 2;
  const std::int64_t tick = sweep.stamp.microseconds ? 0 : ms;
  bool any = false;
  std::int64_t least = 0, most = 0;
  for (const TurnLine::Turn& turn : turns_.turns()) {
    if (Stamp{turn.arrival} - compared_at_ > turn_age) continue;
    const double since = static_cast<double>(turn.tick - compared_device_.count());
    const std::int64_t offset = compared + std::llround(drift * since);
    const Stamp smooth = clock_.to_host(Span(turn.begin) + sweep.until_sent);
    const std::int64_t delay = smooth.ns - turn.tick - sweep.until_sent.count() - offset;
    most = any ? std::min(most, delay) : delay;
    least = any ? std::max(least, delay - tick) : delay - tick;
    any = true;
  }
  const std::int64_t delay = least + (most - least) / 2;
  if (!any || delay < -ms || delay > longest_delay) return;
  delay_ = std::max<std::int64_t>(0, delay);
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
  clock_.reset();
  counter_clock_.reset();
  known_ = false;
}

}  // namespace lidard::hokuyo
