// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "daemon/sink.h"

namespace lidard {

/// Publishes the newest status items on /diagnostics with diagnostic_updater. set() may be called from any
/// thread, the rest belongs to the master thread.
class RosDiagnostics {
 public:
  RosDiagnostics();
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
  std::mutex mutex_;
  std::vector<DiagnosticItem> newest_;
  std::unique_ptr<Updater> updater_;
};

}  // namespace lidard
