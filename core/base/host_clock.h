// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

#include "core/base/time.h"

namespace lidard {

/// Both clocks of a host, read at about the same moment.
struct ClockReading {
  Stamp realtime;       ///< CLOCK_REALTIME, which people and programs set
  Span monotonic{0};    ///< CLOCK_MONOTONIC, which nobody sets
  Span uncertainty{0};  ///< how much earlier than `realtime` the monotonic clock may have been read
};

/// The time scale of a running program: the host's time when the program began, and no steps from there on.
/// The steps are added where a stamp leaves the program. So a step of the host's clock is one step of each
/// stream of stamps, and does not affect ages, time-outs and device clocks.
///
///     realtime  ────────┐              = steady + step()
///                       └──────────
///     steady    ───────────────────    sensors, merging, time-outs
///
/// Small corrections change the rates of both clocks alike (adjtimex(2)) and are no steps.
class HostClock {
 public:
  /// Smaller differences come from reading one clock after the other.
  static constexpr Span least_step = std::chrono::milliseconds(1);

  /// Longest time that a packet may wait in a socket.
  static constexpr Span longest_wait = std::chrono::seconds(1);

  explicit HostClock(const ClockReading& first) : offset_(first.realtime - Stamp{first.monotonic.count()}) {}

  /// To be called at every wake-up. Returns by how much the host's clock was set since the last call, if it
  /// was.
  std::optional<Span> observe(const ClockReading& reading) {
    const Span step = reading.realtime - Stamp{reading.monotonic.count()} - offset_ - step_;
    if (std::chrono::abs(step) <= least_step + reading.uncertainty) return std::nullopt;
    before_ = step_;
    set_at_ = reading.monotonic;
    step_ += step;
    ++steps_;
    return step;
  }

  /// The steady time of a reading.
  Stamp steady(const ClockReading& reading) const { return Stamp{reading.monotonic.count()} + offset_; }
  /// The steady time of a stamp of the host's clock (of a packet, say) from before `reading`, which was
  /// observed. A packet that waited while the clock was set has a stamp of the former time: the younger of
  /// both meanings counts, unless it lies ahead.
  Stamp steady(Stamp stamp, const ClockReading& reading) const {
    const Stamp by_new = stamp - step_, by_old = stamp - before_;
    if (steps_ == 0 || reading.monotonic - set_at_ > longest_wait) return by_new;
    const Stamp now = steady(reading) + reading.uncertainty + least_step;
    const bool is_old = by_old <= now && (by_new > now || by_old > by_new);
    return is_old ? by_old : by_new;
  }
  /// The host's clock at a steady time.
  Stamp realtime(Stamp steady) const { return steady + step_; }
  /// By how much the host's clock was set since the beginning.
  Span step() const { return step_; }
  std::uint64_t steps() const { return steps_; }

 private:
  Span offset_;     // realtime - monotonic at the beginning
  Span step_{0};    // what was added to it since
  Span set_at_{0};  // monotonic
  Span before_{0};  // the same before the last step
  std::uint64_t steps_ = 0;
};

}  // namespace lidard
