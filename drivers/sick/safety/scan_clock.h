// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "core/base/device_clock.h"
#include "core/base/time.h"

namespace lidard::sick {

/// The scan number as a clock: it counts the turns of the mirror, which a crystal controls. The device's own
/// time stamps jitter and belong to no beam (SICK 8022708 p. 11).
class ScanClock {
 public:
  explicit ScanClock(ClockMode mode) : clock_(mode) {}

  /// Host time of the last beam of scan `number`, whose first datagram came at `arrival`.
  Stamp end_of_scan(std::uint32_t number, Span scan_time, Stamp arrival) {
    if (started_ && !paused_ && continues(number, scan_time)) {
      device_ += scan_time * static_cast<std::int32_t>(number - number_);
    } else {
      if (started_ && !paused_) ++restarts_;
      clock_.restart();
      device_ = scan_time;
    }
    started_ = true;
    paused_ = false;
    number_ = number;
    scan_time_ = scan_time;
    clock_.observe(device_, arrival);
    return clock_.to_host(device_);
  }
  /// Standby: the scan number stands while time passes. The next scan starts anew.
  void pause() { paused_ = true; }
  void reset() {
    started_ = false;
    clock_.reset();
  }
  /// Restarts because the device or the host clock jumped.
  std::uint64_t steps() const { return clock_.steps() + restarts_; }
  const DeviceClock& clock() const { return clock_; }

 private:
  bool continues(std::uint32_t number, Span scan_time) const {
    return scan_time == scan_time_ && static_cast<std::int32_t>(number - number_) > 0;
  }

  DeviceClock clock_;
  bool started_ = false;
  bool paused_ = false;
  std::uint64_t restarts_ = 0;
  std::uint32_t number_ = 0;
  Span scan_time_{0};
  Span device_{0};
};

}  // namespace lidard::sick
