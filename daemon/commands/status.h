// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <iosfwd>
#include <string>
#include <utility>
#include <vector>

#include "daemon/health/diagnostics.h"
#include "daemon/health/journal.h"
#include "daemon/health/topic_watch.h"

namespace lidard {

/// The state of a running daemon.
struct DaemonState {
  std::string node;  ///< ROS name
  HostStamp now;     ///< on the host's clock
  Span uptime{0};
  std::string summary;  ///< one line, as reported to systemd
  std::string history;  ///< service_history()
  std::vector<DiagnosticItem> items;
  std::vector<std::pair<std::string, TopicFigures>> topics;
};

/// The answers of a running daemon: JSON of the state with the newest events, JSON of all events, and the
/// state in Prometheus' text format.
std::string status_json(const DaemonState& state, const Journal& journal);
std::string events_json(const Journal& journal);
std::string metrics_text(const DaemonState& state);

/// Options of `lidard status` and `lidard events`.
struct StatusOptions {
  std::string socket;  ///< empty: running_socket_path()
  bool json = false;
  bool watch = false;  ///< repeats every second, until Ctrl-C
};

/// Requests the state of a running daemon and prints it. Returns the exit code: 1 if there is no daemon or,
/// for `status`, if an item is in error.
int run_status(const StatusOptions& options, std::ostream& out, std::ostream& err);
int run_events(const StatusOptions& options, std::ostream& out, std::ostream& err);
int run_metrics(const StatusOptions& options, std::ostream& out, std::ostream& err);
/// Waits for the capture and prints its path; exit code 1 also if the daemon could not write it.
int run_dump(const StatusOptions& options, std::ostream& out, std::ostream& err);

}  // namespace lidard
