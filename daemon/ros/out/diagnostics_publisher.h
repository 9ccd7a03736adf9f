// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/publisher.h>

#include <array>
#include <chrono>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "daemon/pipeline/sink.h"

namespace lidard {

/// Publishes the newest status items of both workers on /diagnostics. set() may be called from any thread,
/// the rest belongs to the master thread.
class DiagnosticsPublisher {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  /// Items without a set() for longer than `longest_age` are published as errors that say so: their thread is
  /// dead. Empty: never.
  explicit DiagnosticsPublisher(std::optional<Span> longest_age = std::nullopt) : longest_age_(longest_age) {}
  /// True if an item came, went or changed its health: publish at once.
  bool set(Worker worker, const std::vector<DiagnosticItem>& items);
  /// The newest items of both.
  std::vector<DiagnosticItem> items() const {
    const std::lock_guard lock(mutex_);
    return joined(newest_[0].items, newest_[1].items);
  }
  /// ROS runs: from now on publish() works. May wait for the master.
  void start();
  /// Publishes the items given to set(), followed by `more`. `awake_since`: end of the last stall of the
  /// process, during which no set() was possible.
  void publish(const std::vector<DiagnosticItem>& more, TimePoint awake_since);
  /// ROS ends. `leave`: without roscpp's destructors, which wait for the master.
  void stop(bool leave);

 private:
  struct Newest {
    std::vector<DiagnosticItem> items;
    TimePoint at;
  };
  std::vector<DiagnosticItem> aged(const Newest& newest, TimePoint awake_since) const;

  const std::optional<Span> longest_age_;
  mutable std::mutex mutex_;
  std::array<Newest, workers> newest_;  // guarded by mutex_
  ros::Publisher publisher_;
};

}  // namespace lidard
