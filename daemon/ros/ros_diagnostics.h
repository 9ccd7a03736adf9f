// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "daemon/pipeline/sink.h"
#include "daemon/ros/ros_callback_thread.h"
#include "daemon/ros/ros_convert.h"

namespace lidard {

/// Publishes the newest status items on /diagnostics with diagnostic_updater. set() may be called from any
/// thread, the rest belongs to the master thread.
class RosDiagnostics {
 public:
  /// Items that nobody has set() anew for longer than `longest_age` are published as errors that say so: the
  /// thread that sets them is dead. Empty: never.
  explicit RosDiagnostics(std::optional<Span> longest_age = std::nullopt) : longest_age_(longest_age) {}
  /// True if the state of an item is another one than before, which is to be told at once.
  bool set(const std::vector<DiagnosticItem>& items) {
    const std::lock_guard lock(mutex_);
    const bool news = items.size() != newest_.size() ||
                      !std::equal(items.begin(), items.end(), newest_.begin(),
                                  [](const auto& a, const auto& b) { return a.health == b.health; });
    newest_ = items;
    set_at_ = std::chrono::steady_clock::now();
    return news;
  }
  /// ROS runs: from now on publish() works. May wait for the master.
  void start() {
    updater_ = std::make_unique<Updater>();
    // The hardware is another one for each status; "none" is what the updater wants to hear then.
    updater_->updater.setHardwareID("none");
  }
  /// Publishes the items given to set(), followed by `more`.
  void publish(const std::vector<DiagnosticItem>& more) {
    if (!updater_) return;
    {
      const std::lock_guard lock(mutex_);
      const Span age = std::chrono::steady_clock::now() - set_at_;
      const bool old = longest_age_ && age > *longest_age_;
      for (const auto& item : newest_) updater_->take(old ? aged(item, age) : item);
    }
    for (const auto& item : more) updater_->take(item);
    updater_->updater.force_update();
  }
  /// ROS ends. With `leave` nothing is told to roscpp, whose destructors wait for the master.
  void drop(bool leave) {
    if (leave) leave_behind(std::move(updater_));
    updater_.reset();
  }

 private:
  static DiagnosticItem aged(DiagnosticItem item, Span age) {
    item.set(Health::error,
             fmt::format("no report from the sensor thread for {:.1f} s: {}", seconds(age), item.message));
    return item;
  }
  struct Updater {
    diagnostic_updater::Updater updater;
    std::map<std::string, DiagnosticItem> items;

    void fill(const std::string& name, diagnostic_updater::DiagnosticStatusWrapper& status) const {
      const auto found = items.find(name);
      if (found == items.end()) {
        status.summary(diagnostic_msgs::DiagnosticStatus::STALE, "no longer reported");
        return;
      }
      to_ros(found->second, status);
    }
    void take(const DiagnosticItem& item) {
      if (items.count(item.name) == 0) {
        const std::string name = item.name;
        updater.add(
            name, [this, name](diagnostic_updater::DiagnosticStatusWrapper& status) { fill(name, status); });
      }
      items[item.name] = item;
    }
  };

  const std::optional<Span> longest_age_;
  std::mutex mutex_;
  std::chrono::steady_clock::time_point set_at_;
  std::vector<DiagnosticItem> newest_;
  std::unique_ptr<Updater> updater_;
};

}  // namespace lidard
