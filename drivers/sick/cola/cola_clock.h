// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

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
  Span observe(std::uint32_t start_us, std::uint32_t transmit_us, Span sweep, Stamp arrival);
  /// The unwrapped time next to that of the last telegram.
  Span near_last(std::uint32_t time_us) const;
  Stamp to_host(Span device) const { return clock_.to_host(device); }
  bool ready() const { return started_; }
  std::uint64_t steps() const { return clock_.steps(); }
  /// Another device, or another recording: the times have nothing to do with the former.
  void reset();

 private:
  DeviceClock clock_;
  bool started_ = false;
  std::uint32_t start_us_ = 0;
  Span device_{0};
  Stamp arrival_;
};

}  // namespace lidard::sick
