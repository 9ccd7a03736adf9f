// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <csignal>

namespace lidard {

/// The last SIGINT or SIGTERM; 0: none.
inline volatile std::sig_atomic_t stop_signal = 0;

/// Installs handlers, so that these signals set stop_signal instead of ending the process.
inline void stop_on_signals() {
  stop_signal = 0;
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int number) { stop_signal = number; });
}
inline bool stopped() { return stop_signal != 0; }

}  // namespace lidard
