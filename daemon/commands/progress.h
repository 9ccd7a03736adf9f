// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>

namespace lidard {

/// The progress line of a long replay on standard error: five times a second on a terminal, else a plain line
/// every ten seconds.
class Progress {
 public:
  Progress();
  /// `part` 0 ... 1 of the capture, `played_s` seconds of it, `frames` and `lost` so far.
  void show(double part, double played_s, std::uint64_t frames, std::uint64_t lost);
  /// True when show() would print now; spares the caller from collecting numbers for each packet.
  bool is_due() const;
  /// Removes the line from the terminal.
  void clear();

 private:
  using Clock = std::chrono::steady_clock;
  bool terminal_;
  Clock::time_point begin_;
  Clock::time_point next_;
};

}  // namespace lidard
