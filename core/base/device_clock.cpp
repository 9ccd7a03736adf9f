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
/// So long must every packet be late before it counts as a step and not as a stall.
constexpr std::int64_t late_limit = 500 * ms;
constexpr std::int64_t window_length = 500 * ms;
/// No clock of a sensor is that far off; a steeper line is a fit to noise.
constexpr double slope_limit = 2000e-6;
/// Until the drift is known, the offset is taken to rise no faster: the worst clock that we hold stamps for.
constexpr double unknown_drift = 1000e-6;
/// In arrival mode a packet that is later is no jitter of a wired network; the host did not look.
constexpr std::int64_t stall_limit = 10 * ms;

}  // namespace

void DeviceClock::reset() {
  ready_ = false;
  late_since_ = 0;
  minima_count_ = 0;
  slope_ = 0;
}

std::int64_t DeviceClock::predicted_offset(std::int64_t device) const {
  return base_offset_ + std::llround(slope_ * static_cast<double>(device - base_device_));
}

void DeviceClock::begin(std::int64_t device, std::int64_t offset) {
  base_device_ = window_begin_ = device;
  base_offset_ = offset;
  window_ = {device, offset};
  ready_ = true;
}

void DeviceClock::observe(Span device_span, Stamp arrival) {
  const std::int64_t device = device_span.count();
  const std::int64_t offset = arrival.ns - device;
  if (ready_) {
    follow(device, arrival.ns);
  } else {
    begin(device, offset);
  }
  const std::int64_t predicted = predicted_offset(device);
  placed_ = offset - predicted > stall_limit ? predicted : offset;
}

void DeviceClock::follow(std::int64_t device, std::int64_t arrival) {
  const std::int64_t offset = arrival - device;
  const std::int64_t residual = offset - predicted_offset(device);
  if (residual > step_limit && late_since_ == 0) late_since_ = arrival;
  const bool late_for_long = residual > step_limit && std::abs(arrival - late_since_) > late_limit;
  if (residual < -step_limit || late_for_long) {
    ++steps_;
    reset();
    return begin(device, offset);
  }
  if (residual > step_limit) return;
  late_since_ = 0;
  if (!knows_drift()) {
    const double passed = static_cast<double>(std::max<std::int64_t>(0, device - base_device_));
    base_offset_ = std::min<std::int64_t>(offset, base_offset_ + std::llround(unknown_drift * passed));
    base_device_ = std::max(base_device_, device);
  } else if (residual < 0) {
    base_offset_ += residual;
  }
  if (offset < window_.offset) window_ = {device, offset};
  if (device - window_begin_ >= window_length) close_window(device, offset);
}

void DeviceClock::close_window(std::int64_t device, std::int64_t offset) {
  if (minima_count_ == max_minima) {
    std::move(minima_ + 1, minima_ + max_minima, minima_);
    --minima_count_;
  }
  minima_[minima_count_++] = window_;
  window_begin_ = device;
  window_ = {device, offset};
  if (knows_drift()) fit();
}

/// Of all lines that no minimum lies below, the one that is nearest to them in sum: the edge of their lower
/// hull under their middle. A window in which every packet was late does not lift it.
double DeviceClock::slope_under_the_middle() const {
  std::size_t hull[max_minima] = {};
  std::size_t count = 0;
  // Relative to the newest minimum, so that doubles hold nanoseconds exactly.
  const Minimum& origin = minima_[minima_count_ - 1];
  const auto x = [&](std::size_t i) { return static_cast<double>(minima_[i].device - origin.device); };
  const auto slope = [&](std::size_t i, std::size_t j) {
    const double width = x(j) - x(i);
    return width > 0 ? static_cast<double>(minima_[j].offset - minima_[i].offset) / width : 0;
  };
  double middle = 0;
  for (std::size_t i = 0; i < minima_count_; ++i) {
    middle += x(i) / static_cast<double>(minima_count_);
    while (count >= 2 && slope(hull[count - 2], hull[count - 1]) >= slope(hull[count - 1], i)) --count;
    hull[count++] = i;
  }
  std::size_t edge = 1;
  while (edge + 1 < count && x(hull[edge]) < middle) ++edge;
  return slope(hull[edge - 1], hull[edge]);
}

void DeviceClock::fit() {
  slope_ = std::clamp(slope_under_the_middle(), -slope_limit, slope_limit);
  const Minimum& origin = minima_[minima_count_ - 1];
  double lowest = 0;
  for (std::size_t i = 0; i < minima_count_; ++i) {
    const auto x = static_cast<double>(minima_[i].device - origin.device);
    lowest = std::min(lowest, static_cast<double>(minima_[i].offset - origin.offset) - slope_ * x);
  }
  base_device_ = origin.device;
  base_offset_ = origin.offset + std::llround(lowest);
}

Stamp DeviceClock::to_host(Span device) const {
  if (!ready_) return Stamp{device.count()};
  const std::int64_t offset = mode_ == ClockMode::arrival ? placed_ : predicted_offset(device.count());
  return Stamp{device.count() + offset};
}

}  // namespace lidard
