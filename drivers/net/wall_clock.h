// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include "core/base/host_clock.h"

namespace lidard {

/// The host's time: the time scale of arrival stamps.
inline HostStamp wall_clock() {
  return {std::chrono::duration_cast<Span>(std::chrono::system_clock::now().time_since_epoch()).count()};
}

/// Both clocks, the best of a few readings, since the thread may be interrupted between the two.
inline ClockReading read_clocks() {
  const auto monotonic = [] { return Span(std::chrono::steady_clock::now().time_since_epoch()); };
  ClockReading best;
  best.uncertainty = Span::max();
  for (int i = 0; i < 3; ++i) {
    const Span before = monotonic();
    const HostStamp realtime = wall_clock();
    const Span took = monotonic() - before;
    if (took < best.uncertainty) best = {realtime, before, took};
    if (took < std::chrono::microseconds(20)) break;
  }
  return best;
}

}  // namespace lidard
