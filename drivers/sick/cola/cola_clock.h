// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/base/device_clock.h"
#include "core/base/time.h"

namespace lidard::sick {

/// The microseconds since start-up in the telegrams, unwrapped and mapped to host time.
class ColaClock {
 public:
  explicit ColaClock(ClockMode mode) : clock_(mode) {}

  /// A telegram arrived. Its two times are `start_us` and `transmit_us`; `sweep` is how long it measured,
  /// used where the device does not tell when it transmitted. Returns the unwrapped start time.
  Span observe(std::uint32_t start_us, std::uint32_t transmit_us, Span sweep, Stamp arrival) {
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
  /// The unwrapped time next to that of the last telegram.
  Span near_last(std::uint32_t time_us) const {
    return device_ + std::chrono::microseconds(static_cast<std::int32_t>(time_us - start_us_));
  }
  Stamp to_host(Span device) const { return clock_.to_host(device); }
  bool ready() const { return started_; }
  std::uint64_t steps() const { return clock_.steps(); }
  /// Another device, or another recording: the times have nothing to do with the former.
  void reset() {
    started_ = false;
    clock_.reset();
  }

 private:
  static constexpr Span wrap = std::chrono::microseconds(std::int64_t{1} << 32);
  /// A longer way from measurement to transmission is no time but an empty field.
  static constexpr Span longest_way = std::chrono::seconds(10);

  DeviceClock clock_;
  bool started_ = false;
  std::uint32_t start_us_ = 0;
  Span device_{0};
  Stamp arrival_;
};

}  // namespace lidard::sick
