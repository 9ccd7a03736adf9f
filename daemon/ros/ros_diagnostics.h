// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "daemon/pipeline/sink.h"

namespace lidard {

/// Publishes the newest status items on /diagnostics with diagnostic_updater. set() may be called from any
/// thread, the rest belongs to the master thread.
class RosDiagnostics {
 public:
  /// Items that nobody has set() anew for longer than `longest_age` are published as errors that say so: the
  /// thread that sets them is dead. Empty: never.
  explicit RosDiagnostics(std::optional<Span> longest_age = std::nullopt);
  ~RosDiagnostics();

  /// True if the state of an item is another one than before, which is to be told at once.
  bool set(const std::vector<DiagnosticItem>& items);
  /// ROS runs: from now on publish() works. May wait for the master.
  void start();
  /// Publishes the items given to set(), followed by `more`.
  void publish(const std::vector<DiagnosticItem>& more);
  /// ROS ends. With `leave` nothing is told to roscpp, whose destructors wait for the master.
  void drop(bool leave);

 private:
  struct Updater;
  const std::optional<Span> longest_age_;
  std::mutex mutex_;
  std::chrono::steady_clock::time_point set_at_;
  std::vector<DiagnosticItem> newest_;
  std::unique_ptr<Updater> updater_;
};

}  // namespace lidard
