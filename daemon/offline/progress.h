// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <string>

namespace lidard {

/// The progress line of a long job on standard error: five times a second on a terminal, else a plain line
/// every ten seconds or, if `quiet`, none.
class Progress {
 public:
  explicit Progress(bool quiet = false) : quiet_(quiet && !terminal_) {}

  /// True if show() would print now, so that callers need not collect numbers for every packet.
  bool is_due() const { return !quiet_ && Clock::now() >= next_; }
  /// Prints that `part` (0 ... 1) of the job is done, with `words`.
  void show(double part, const std::string& words) {
    next_ = Clock::now() + period();
    const double left = part > 0 ? elapsed() * (1 - part) / part : 0;
    std::fprintf(stderr, "%s%3.0f %%  %s  %.0f s left%s", terminal_ ? "\r" : "", 100 * part, words.c_str(),
                 left, terminal_ ? "\033[K" : "\n");
  }
  /// s since the begin.
  double elapsed() const { return std::chrono::duration<double>(Clock::now() - begin_).count(); }
  /// Removes the line from the terminal.
  void clear() {
    if (terminal_) std::fputs("\r\033[K", stderr);
  }

 private:
  using Clock = std::chrono::steady_clock;
  std::chrono::milliseconds period() const { return std::chrono::milliseconds(terminal_ ? 200 : 10000); }

  const bool terminal_ = isatty(STDERR_FILENO) == 1;
  const bool quiet_;
  const Clock::time_point begin_ = Clock::now();
  Clock::time_point next_ = begin_ + period();
};

}  // namespace lidard
