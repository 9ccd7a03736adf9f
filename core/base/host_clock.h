// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include "core/base/time.h"

namespace lidard {

/// Both clocks of a host, read at about the same moment.
struct ClockReading {
  HostStamp realtime;   ///< CLOCK_REALTIME, which people and programs set
  Span monotonic{0};    ///< CLOCK_MONOTONIC, which nobody sets
  Span uncertainty{0};  ///< how much earlier than `realtime` the monotonic clock may have been read
};

/// By how much the host's clock was set since the program began; converts between the two time scales. Shared
/// by threads. In a replay both scales are one.
class ClockStep {
 public:
  explicit ClockStep(Span step = Span(0)) : step_(step) {}
  void set(Span step) { step_ = step; }
  HostStamp host(Stamp steady) const { return {(steady + step_.load()).ns}; }
  Stamp steady(HostStamp host) const { return {(host - step_.load()).ns}; }

 private:
  std::atomic<Span> step_;
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

  explicit HostClock(const ClockReading& first) : offset_(first.realtime - at(first.monotonic)) {}

  /// To be called at every wake-up. Returns by how much the host's clock was set since the last call, if it
  /// was.
  std::optional<Span> observe(const ClockReading& reading) {
    const Span step = reading.realtime - at(reading.monotonic) - offset_ - step_;
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
  Stamp steady(HostStamp stamp, const ClockReading& reading) const {
    const Stamp by_new = ClockStep(step_).steady(stamp), by_old = ClockStep(before_).steady(stamp);
    if (steps_ == 0 || reading.monotonic - set_at_ > longest_wait) return by_new;
    const Stamp now = steady(reading) + reading.uncertainty + least_step;
    const bool is_old = by_old <= now && (by_new > now || by_old > by_new);
    return is_old ? by_old : by_new;
  }
  /// By how much the host's clock was set since the beginning.
  Span step() const { return step_; }
  std::uint64_t steps() const { return steps_; }

 private:
  static HostStamp at(Span monotonic) { return {monotonic.count()}; }

  Span offset_;     // realtime - monotonic at the beginning
  Span step_{0};    // by which the host's clock was set since the beginning
  Span set_at_{0};  // monotonic time of the last step
  Span before_{0};  // step_ before the last step
  std::uint64_t steps_ = 0;
};

}  // namespace lidard
