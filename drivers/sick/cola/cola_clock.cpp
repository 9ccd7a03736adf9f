// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/cola/cola_clock.h"

#include <algorithm>
#include <cmath>

namespace lidard::sick {
namespace {

constexpr Span wrap = std::chrono::microseconds(std::int64_t{1} << 32);
/// A longer way from measurement to transmission is no time but an empty field.
constexpr Span longest_way = std::chrono::seconds(10);

}  // namespace

Span ColaClock::observe(std::uint32_t start_us, std::uint32_t transmit_us, Span sweep, Stamp arrival) {
  if (!started_) {
    device_ = std::chrono::microseconds(start_us);
  } else {
    const Span ahead = std::chrono::microseconds(start_us - start_us_);
    // More than one wrap fits into a long silence.
    const double wraps = seconds(arrival - arrival_ - ahead) / seconds(wrap);
    device_ += ahead + wrap * static_cast<std::int64_t>(std::max(0.0, std::round(wraps)));
  }
  started_ = true;
  start_us_ = start_us;
  arrival_ = arrival;
  const Span way = std::chrono::microseconds(transmit_us - start_us);
  clock_.observe(device_ + (way <= longest_way ? way : sweep), arrival);
  return device_;
}

Span ColaClock::near_last(std::uint32_t time_us) const {
  return device_ + std::chrono::microseconds(static_cast<std::int32_t>(time_us - start_us_));
}

void ColaClock::reset() {
  started_ = false;
  clock_.reset();
}

}  // namespace lidard::sick
