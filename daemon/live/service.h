// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/base/time.h"

namespace lidard {

/// Sends the log to stderr: with the journal's level prefixes ("<6>…") if stderr is the journal, else with
/// time and, on a terminal, colours. `level`: trace, debug, info, warning, error, critical or off.
void set_up_logging(const std::string& level = "info");
/// True if file descriptor 2 is the journal's stream that systemd announced in $JOURNAL_STREAM.
bool stderr_is_journal();

/// systemd's record of earlier runs of this service: "restarted 3 times by systemd, last killed by its
/// watchdog at 2026-11-23T14:03:22Z"; empty: none or unknown. The call may need half a second.
std::string service_history();

/// Reports the state of the daemon to systemd. Does nothing without a service manager ($NOTIFY_SOCKET).
class ServiceManager {
 public:
  /// Reports READY: the configuration is valid, sockets are open, the pipeline runs.
  void ready(const std::string& status);
  /// Sets the line in `systemctl status`.
  void status(const std::string& text);
  /// Reports RELOADING: a changed configuration is being applied, until the next ready().
  void reloading();
  void stopping();
  /// Feeds the watchdog; call it at least twice per WatchdogSec= of the unit.
  void alive();
};

}  // namespace lidard
