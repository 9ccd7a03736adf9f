// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/commands/progress.h"

#include <unistd.h>

#include <cstdio>

namespace lidard {

Progress::Progress() : terminal_(isatty(STDERR_FILENO) == 1), begin_(Clock::now()) {
  next_ = begin_ + (terminal_ ? std::chrono::milliseconds(200) : std::chrono::milliseconds(10000));
}

bool Progress::is_due() const { return Clock::now() >= next_; }

void Progress::show(double part, double played_s, std::uint64_t frames, std::uint64_t lost) {
  next_ = Clock::now() + (terminal_ ? std::chrono::milliseconds(200) : std::chrono::milliseconds(10000));
  const double elapsed = std::chrono::duration<double>(Clock::now() - begin_).count();
  const double left = part > 0 ? elapsed * (1 - part) / part : 0;
  std::fprintf(stderr, "%s%3.0f %%  %.1f s  %.1f x  %llu frames  %llu lost  %.0f s left%s",
               terminal_ ? "\r" : "", 100 * part, played_s, elapsed > 0 ? played_s / elapsed : 0,
               static_cast<unsigned long long>(frames), static_cast<unsigned long long>(lost), left,
               terminal_ ? "\033[K" : "\n");
}

void Progress::clear() {
  if (terminal_) std::fputs("\r\033[K", stderr);
}

}  // namespace lidard
