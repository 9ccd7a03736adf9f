// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <iosfwd>
#include <string>
#include <utility>
#include <vector>

#include "daemon/live/journal.h"
#include "daemon/live/topic_watch.h"
#include "daemon/pipeline/sink.h"

namespace lidard {

/// What a running daemon knows of itself.
struct DaemonState {
  std::string node;  ///< ROS name
  Stamp now;         ///< on the host's clock
  Span uptime{0};
  std::string summary;  ///< one line, as systemd has it
  std::string history;  ///< service_history()
  std::vector<DiagnosticItem> items;
  std::vector<std::pair<std::string, TopicFigures>> topics;
};

/// The answers of a running daemon: JSON of its state and its newest events, of all events, and the state as
/// Prometheus' text format has it.
std::string status_json(const DaemonState& state, const Journal& journal);
std::string events_json(const Journal& journal);
std::string metrics_text(const DaemonState& state);

/// What `lidard status` and `lidard events` were asked for.
struct StatusOptions {
  std::string socket;  ///< empty: running_socket_path()
  bool json = false;
  bool watch = false;  ///< again every second, until Ctrl-C
};

/// Asks a running daemon and prints its answer. Returns the exit code: 0, or 1 if there is no daemon; of
/// `status` 1 too if something is in error.
int run_status(const StatusOptions& options, std::ostream& out, std::ostream& err);
int run_events(const StatusOptions& options, std::ostream& out, std::ostream& err);
int run_metrics(const StatusOptions& options, std::ostream& out, std::ostream& err);
/// Waits for the capture and prints its path; exit code 1 too if the daemon could not write one.
int run_dump(const StatusOptions& options, std::ostream& out, std::ostream& err);

}  // namespace lidard
