// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/safety/scan_clock.h"

namespace lidard::sick {
namespace {

/// Scans later than the scan number allows by so much are no stall of the network: the mirror stood still or
/// a clock was set.
constexpr Span longest_stall = std::chrono::milliseconds(500);

}  // namespace

bool ScanClock::continues(std::uint32_t number, Span scan_time, Stamp arrival) const {
  const auto ahead = static_cast<std::int32_t>(number - number_);
  return scan_time == scan_time_ && ahead > 0 && arrival - arrival_ - scan_time * ahead <= longest_stall;
}

Stamp ScanClock::end_of_scan(std::uint32_t number, Span scan_time, Stamp arrival) {
  if (started_ && !paused_ && continues(number, scan_time, arrival)) {
    device_ += scan_time * static_cast<std::int32_t>(number - number_);
  } else {
    if (started_ && !paused_) ++restarts_;
    clock_.reset();
    device_ = scan_time;
  }
  started_ = true;
  paused_ = false;
  number_ = number;
  scan_time_ = scan_time;
  arrival_ = arrival;
  clock_.observe(device_, arrival);
  return clock_.to_host(device_);
}

}  // namespace lidard::sick
