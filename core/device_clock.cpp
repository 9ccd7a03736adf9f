// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/device_clock.h"

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
/// Crystals are within 100 ppm; a steeper line is a fit to noise.
constexpr double slope_limit = 500e-6;
constexpr std::size_t minima_for_slope = 4;

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

void DeviceClock::observe(Span device_span, Stamp arrival) {
  const std::int64_t device = device_span.count();
  const std::int64_t offset = arrival.ns - device;
  if (mode_ == ClockMode::arrival || !ready_) {
    base_device_ = window_begin_ = device;
    base_offset_ = offset;
    window_ = {device, offset};
    ready_ = true;
    return;
  }
  const std::int64_t residual = offset - predicted_offset(device);
  if (residual > step_limit && late_since_ == 0) late_since_ = device;
  const bool late_for_long = residual > step_limit && std::abs(device - late_since_) > late_limit;
  if (residual < -step_limit || late_for_long) {
    ++steps_;
    reset();
    observe(device_span, arrival);
    return;
  }
  if (residual > step_limit) return;
  late_since_ = 0;
  if (residual < 0) base_offset_ += residual;
  if (offset < window_.offset) window_ = {device, offset};
  if (device - window_begin_ < window_length) return;
  if (minima_count_ == max_minima) {
    std::move(minima_ + 1, minima_ + max_minima, minima_);
    --minima_count_;
  }
  minima_[minima_count_++] = window_;
  window_begin_ = device;
  window_ = {device, offset};
  fit();
}

void DeviceClock::fit() {
  // Relative to the newest minimum, so that doubles hold nanoseconds exactly.
  const Minimum origin = minima_[minima_count_ - 1];
  double sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (std::size_t i = 0; i < minima_count_; ++i) {
    const auto x = static_cast<double>(minima_[i].device - origin.device);
    const auto y = static_cast<double>(minima_[i].offset - origin.offset);
    sx += x, sy += y, sxx += x * x, sxy += x * y;
  }
  const auto n = static_cast<double>(minima_count_);
  const double determinant = n * sxx - sx * sx;
  double slope = minima_count_ >= minima_for_slope && determinant > 0 ? (n * sxy - sx * sy) / determinant : 0;
  if (std::abs(slope) > slope_limit) slope = 0;
  double lowest = 0;
  for (std::size_t i = 0; i < minima_count_; ++i) {
    const auto x = static_cast<double>(minima_[i].device - origin.device);
    lowest = std::min(lowest, static_cast<double>(minima_[i].offset - origin.offset) - slope * x);
  }
  base_device_ = origin.device;
  base_offset_ = origin.offset + std::llround(lowest);
  slope_ = slope;
}

Stamp DeviceClock::to_host(Span device) const {
  return Stamp{device.count() + (ready_ ? predicted_offset(device.count()) : 0)};
}

}  // namespace lidard
