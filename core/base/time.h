// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>

namespace lidard {

/// A signed length of time. Differences of stamps are signed so that a stamp going backwards stays small.
using Span = std::chrono::nanoseconds;

/// A point in time on one of two scales, which do not mix: nanoseconds since the Unix epoch.
template <class Scale>
struct TimePoint {
  std::int64_t ns = 0;

  friend constexpr bool operator==(TimePoint a, TimePoint b) { return a.ns == b.ns; }
  friend constexpr bool operator!=(TimePoint a, TimePoint b) { return a.ns != b.ns; }
  friend constexpr bool operator<(TimePoint a, TimePoint b) { return a.ns < b.ns; }
  friend constexpr bool operator>(TimePoint a, TimePoint b) { return a.ns > b.ns; }
  friend constexpr bool operator<=(TimePoint a, TimePoint b) { return a.ns <= b.ns; }
  friend constexpr bool operator>=(TimePoint a, TimePoint b) { return a.ns >= b.ns; }
  friend constexpr TimePoint operator+(TimePoint a, Span d) { return {a.ns + d.count()}; }
  friend constexpr TimePoint operator-(TimePoint a, Span d) { return {a.ns - d.count()}; }
  friend constexpr Span operator-(TimePoint a, TimePoint b) { return Span(a.ns - b.ns); }
};

/// Time without steps (HostClock), or the time of a capture: sensors, merging, time-outs.
using Stamp = TimePoint<struct SteadyScale>;
/// The host's clock (CLOCK_REALTIME), which may be set: arrivals as the kernel stamps them, ROS, files.
using HostStamp = TimePoint<struct HostScale>;

/// A clock that goes back by more than this was set, or the stream began anew.
constexpr Span restart_limit = std::chrono::seconds(1);

/// Length of `d` in seconds.
constexpr double seconds(Span d) { return static_cast<double>(d.count()) * 1e-9; }

/// `s` seconds as a span, rounded to the nearest nanosecond; |s| must be below 292 years.
constexpr Span span_from_seconds(double s) {
  return Span(static_cast<std::int64_t>(s * 1e9 + (s < 0 ? -0.5 : 0.5)));
}

/// Stamps of one stream of frames: strictly increasing, since consumers drop what is not newer. Only a clock
/// that was set back by restart_limit may go back.
class SteadyStamps {
 public:
  Stamp next(Stamp stamp) {
    const bool back_a_little = stamp <= last_ && last_ - stamp < restart_limit;
    last_ = back_a_little ? last_ + Span(1) : stamp;
    return last_;
  }
  void reset() { last_ = Stamp(); }

 private:
  Stamp last_;
};

}  // namespace lidard
