// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/device_clock.h"

#include <algorithm>
#include <cmath>

namespace lidard {
namespace {

constexpr std::int64_t ms = 1'000'000;
/// An arrival this far off the estimate is no network jitter: a clock was set, or a long stall.
constexpr std::int64_t step_limit = 50 * ms;
/// Packets that are all late for longer are a step, not a stall.
constexpr std::int64_t late_limit = 500 * ms;
/// Windows grow from the first length to the last: a crystal's drift is steady for as long as all windows
/// last then (16 s), and each of the slowest sensor's windows holds some packets.
constexpr std::int64_t first_window = 50 * ms, last_window = 400 * ms;
constexpr std::int64_t drift_known_after = 2000 * ms;
/// No sensor's clock deviates by more; a steeper line is a fit to noise.
constexpr double slope_limit = 2000e-6;
/// Standard deviation of the drift between two unknown crystals, and the least one after a reboot.
constexpr double unknown_drift = 150e-6, known_drift = 20e-6;
/// The same where the rate changed: ntpd slews a host's clock by up to 500 ppm.
constexpr double slewed_drift = 200e-6;
/// Deviation of the windows' lowest delays: assumed before any is known, and the least one.
constexpr double usual_spread = 0.2e6, least_spread = 1e3;
/// The variance of n minima grows by the factor 1 + few_minima / n.
constexpr double few_minima = 24;
/// The median of an exponential distribution, as a part of its mean.
constexpr double ln_2 = 0.6931;
/// The rate changed if no packet reached the line for rate_time and each window was above it by rate_limit
/// and by rate_spreads times the deviation of the minima.
constexpr std::int64_t rate_time = 2000 * ms, rate_limit = 3 * ms / 20, rate_spreads = 3;
/// In arrival mode a packet that is later is no jitter of a wired network: the host stalled.
constexpr std::int64_t stall_limit = 10 * ms;
/// The arrivals stand if they advance, apart from whole seconds, by less than this part of the device's time.
constexpr std::int64_t standing_part = 8;
/// After a longer time without packets, whole seconds mean nothing.
constexpr std::int64_t longest_gap = 500 * ms;
/// The least step of device time from packet to packet, for those in the wrong order.
constexpr std::int64_t least_step = ms / 10;
/// Packets that are early by more than early_limit while the arrivals stand are held, as are those of a run
/// of run_limit. A host that stalls drains its burst sooner than after longest_run.
constexpr std::int64_t early_limit = ms, run_limit = 1000 * ms, longest_run = 15'000 * ms;
constexpr std::int64_t lacked_after = 3000 * ms;

/// A span without its whole seconds, -0.5 to 0.5 s.
std::int64_t beyond_seconds(std::int64_t span) {
  constexpr std::int64_t second = 1000 * ms;
  const std::int64_t rest = span % second;
  return rest > second / 2 ? rest - second : rest < -second / 2 ? rest + second : rest;
}

}  // namespace

bool DeviceClock::stands(Span device, Stamp arrival) const {
  const std::int64_t passed = device.count() - newest_;
  const std::int64_t moved = std::abs(beyond_seconds(arrival.ns - newest_arrival_));
  if (!ready_ || device.count() < run_.device) return false;
  if (passed >= longest_gap) return held_ && moved < early_limit;
  return moved * standing_part <= std::max(passed, least_step);
}

/// True if the packet's arrival shows nothing.
bool DeviceClock::hold(std::int64_t device, std::int64_t arrival) {
  if (!stands(Span(device), Stamp{arrival})) {
    // A burst at the begin of a stream: its last packet is the best one.
    const bool was_burst = held_ && early_ && newest_ - run_.device < lacked_after;
    held_ = early_ = false;
    if (was_burst) {
      const std::int64_t offset = newest_arrival_ - newest_;
      base_offset_ += std::min<std::int64_t>(0, offset - predicted_offset(newest_));
      if (offset < window_.offset) window_ = {newest_, offset};
    }
    if (device - begun_ >= longest_run) owed_ = 0;
    run_ = {device, arrival, predicted_offset(device) - owed_};
    return false;
  }
  const std::int64_t passed = device - run_.device;
  early_ = early_ || arrival - device < run_.offset - early_limit || passed > longest_run;
  lacked_ = lacked_ || (early_ && passed > lacked_after);
  if (!held_ && (early_ || passed > run_limit)) {
    held_ = true;
    base_offset_ += run_.offset - predicted_offset(run_.device);
  }
  if (held_) late_since_ = 0;
  return held_;
}

void DeviceClock::restart() {
  if (ready_) newest_host_ = newest().ns;
  if (knows_drift_) {
    const std::int64_t seen = std::max(minima_[minima_count_ - 1].device - minima_[0].device, window_length_);
    const double deviation = 4 * static_cast<double>(spread_) / static_cast<double>(seen);
    expected_slope_ = slope_;
    slope_deviation_ = std::clamp(deviation, known_drift, unknown_drift);
  }
  ready_ = knows_drift_ = false;
  late_since_ = 0;
  minima_count_ = 0;
  spread_ = 0;
  slope_ = expected_slope_;
}

void DeviceClock::reset() {
  knows_drift_ = held_ = early_ = lacked_ = false;
  expected_slope_ = slope_deviation_ = 0;
  restart();
}

void DeviceClock::begin(std::int64_t device, std::int64_t arrival, std::int64_t owed) {
  std::int64_t offset = arrival - device;
  // Without arrival times the stamps go on, by the device's clock unless it began anew.
  if (held_) offset = std::max({offset, base_offset_, newest_host_ - device});
  if (!(slope_deviation_ > 0)) slope_deviation_ = unknown_drift;
  base_device_ = begun_ = window_begin_ = device;
  window_length_ = first_window;
  base_offset_ = offset;
  owed_ = owed;
  window_ = {device, offset};
  run_ = {device, arrival, offset - owed};
  ready_ = true;
}

void DeviceClock::observe(Span device_span, Stamp arrival) {
  const std::int64_t device = device_span.count();
  const std::int64_t offset = arrival.ns - device;
  if (!ready_)
    begin(device, arrival.ns, 0);
  else if (!hold(device, arrival.ns))
    follow(device, arrival.ns);
  newest_ = device;
  newest_arrival_ = arrival.ns;
  const std::int64_t predicted = predicted_offset(device);
  placed_ = held_ || offset - predicted > stall_limit ? predicted : offset;
}

void DeviceClock::follow(std::int64_t device, std::int64_t arrival) {
  const std::int64_t offset = arrival - device;
  const std::int64_t residual = offset - predicted_offset(device);
  if (residual > step_limit && late_since_ == 0) late_since_ = arrival;
  const bool late_for_long = residual > step_limit && std::abs(arrival - late_since_) > late_limit;
  const std::int64_t owed = std::max<std::int64_t>(0, owed_ + residual);
  if (residual < -step_limit || residual > longest_stall.count() || late_for_long) {
    ++steps_;
    restart();
    return begin(device, arrival, owed);
  }
  if (residual > step_limit) return;
  late_since_ = 0;
  if (residual < 0) {
    base_offset_ += residual;
    owed_ = owed;
  }
  if (offset < window_.offset) window_ = {device, offset};
  if (device - window_begin_ >= window_length_) close_window(device, offset);
}

void DeviceClock::close_window(std::int64_t device, std::int64_t offset) {
  if (minima_count_ == max_minima && window_length_ < last_window) {
    halve();
  } else if (minima_count_ == max_minima) {
    std::move(minima_ + 1, minima_ + max_minima, minima_);
    --minima_count_;
  }
  minima_[minima_count_++] = window_;
  forget_former_rate();
  window_begin_ = device;
  window_ = {device, offset};
  knows_drift_ = knows_drift_ || device - begun_ >= drift_known_after;
  fit();
}

/// Forgets the minima before a change of rate: none of the last packets reached the line (a slewed host clock
/// changes its rate by 500 ppm and more).
void DeviceClock::forget_former_rate() {
  const std::int64_t now = minima_[minima_count_ - 1].device;
  const std::int64_t limit = rate_limit + rate_spreads * spread_;
  std::size_t first = minima_count_;
  while (first > 0 && now - minima_[first - 1].device < rate_time) {
    --first;
    if (minima_[first].offset - predicted_offset(minima_[first].device) <= limit) return;
  }
  if (first == 0) return;
  std::move(minima_ + first, minima_ + minima_count_, minima_);
  minima_count_ -= first;
  expected_slope_ = slope_;
  slope_deviation_ = slewed_drift;
}

/// Makes one window of two.
void DeviceClock::halve() {
  minima_count_ /= 2;
  for (std::size_t i = 0; i < minima_count_; ++i) {
    const Minimum &first = minima_[2 * i], &second = minima_[2 * i + 1];
    minima_[i] =
        predicted_offset(first.device) - first.offset > predicted_offset(second.device) - second.offset
            ? first
            : second;
  }
  window_length_ *= 2;
}

/// The likeliest of the lines that no minimum lies below. If all slopes were equally likely, this would be
/// the line nearest to the minima in sum: the edge of their lower hull under their middle. A window in which
/// every packet was late does not lift the line.
double DeviceClock::likeliest_slope() {
  std::size_t hull[max_minima] = {};
  std::size_t count = 0;
  // Relative to the newest minimum, so that doubles hold nanoseconds exactly.
  const Minimum& origin = minima_[minima_count_ - 1];
  const auto x = [&](std::size_t i) { return static_cast<double>(minima_[i].device - origin.device); };
  const auto y = [&](std::size_t i) { return static_cast<double>(minima_[i].offset - origin.offset); };
  const auto slope = [&](std::size_t i, std::size_t j) {
    const double width = x(j) - x(i);
    return width > 0 ? (y(j) - y(i)) / width : 0;
  };
  double x_sum = 0;
  for (std::size_t i = 0; i < minima_count_; ++i) {
    x_sum += x(i);
    while (count >= 2 && slope(hull[count - 2], hull[count - 1]) >= slope(hull[count - 1], i)) --count;
    hull[count++] = i;
  }
  if (count < 2) return expected_slope_;
  const auto n = static_cast<double>(minima_count_);
  std::size_t edge = 1;
  while (edge + 1 < count && x(hull[edge]) * n < x_sum) ++edge;
  const double nearest = slope(hull[edge - 1], hull[edge]);
  double deviations[max_minima] = {usual_spread};
  for (std::size_t i = 1; i < minima_count_; ++i)
    deviations[i] = std::abs(y(i) - y(i - 1) - nearest * (x(i) - x(i - 1)));
  // Differences of exponential delays are distributed like the delays. Half of them may be stalls.
  double* const median = deviations + minima_count_ / 2;
  std::nth_element(deviations, median, deviations + minima_count_);
  const double spread = std::max(least_spread, *median / ln_2);
  spread_ = std::llround(spread);
  // A line that turns about a corner of the hull loses in sum what it gains in slope; it is best where both
  // are in balance, or lies on the next edge.
  const double factor = 1 + few_minima / n;
  const double weight = slope_deviation_ * slope_deviation_ / (spread * factor);
  double best = expected_slope_;
  for (std::size_t i = 0; i < count; ++i) {
    best = expected_slope_ + weight * (x_sum - n * x(hull[i]));
    if (i > 0) best = std::max(best, slope(hull[i - 1], hull[i]));
    if (i + 1 == count || best <= slope(hull[i], hull[i + 1])) break;
  }
  return best;
}

void DeviceClock::fit() {
  slope_ = std::clamp(likeliest_slope(), -slope_limit, slope_limit);
  const Minimum& origin = minima_[minima_count_ - 1];
  double lowest = 0;
  for (std::size_t i = 0; i < minima_count_; ++i) {
    const auto x = static_cast<double>(minima_[i].device - origin.device);
    lowest = std::min(lowest, static_cast<double>(minima_[i].offset - origin.offset) - slope_ * x);
  }
  base_device_ = origin.device;
  base_offset_ = origin.offset + std::llround(lowest);
}

}  // namespace lidard
