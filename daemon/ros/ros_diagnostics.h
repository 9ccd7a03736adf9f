// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "daemon/pipeline/sink.h"
#include "daemon/ros/ros_callback_thread.h"
#include "daemon/ros/ros_convert.h"

namespace lidard {

/// Publishes the newest status items of both lanes on /diagnostics with diagnostic_updater. set() may be
/// called from any thread, the rest belongs to the master thread.
class RosDiagnostics {
 public:
  /// Items that nobody has set() anew for longer than `longest_age` are published as errors that say so: the
  /// thread that sets them is dead. Empty: never.
  explicit RosDiagnostics(std::optional<Span> longest_age = std::nullopt) : longest_age_(longest_age) {}
  /// True if the state of an item is another one than before, which is to be told at once.
  bool set(std::size_t lane, const std::vector<DiagnosticItem>& items) {
    const std::lock_guard lock(mutex_);
    Newest& newest = newest_.at(lane);
    const bool news = items.size() != newest.items.size() ||
                      !std::equal(items.begin(), items.end(), newest.items.begin(),
                                  [](const auto& a, const auto& b) { return a.health == b.health; });
    newest = {items, std::chrono::steady_clock::now()};
    return news;
  }
  /// ROS runs: from now on publish() works. May wait for the master.
  void start() {
    updater_ = std::make_unique<Updater>();
    // The hardware is another one for each status; "none" is what the updater wants to hear then.
    updater_->updater.setHardwareID("none");
  }
  /// Publishes the items given to set(), followed by `more`. `awake_since`: since when this process runs
  /// without having stood; nobody could set() anything before.
  void publish(const std::vector<DiagnosticItem>& more, std::chrono::steady_clock::time_point awake_since) {
    if (!updater_) return;
    updater_->items.clear();
    {
      const std::lock_guard lock(mutex_);
      for (const auto& item :
           joined(newest_[0].aged(longest_age_, awake_since), newest_[1].aged(longest_age_, awake_since)))
        updater_->take(item);
    }
    for (const auto& item : more) updater_->take(item);
    updater_->forget();
    updater_->updater.force_update();
  }
  /// ROS ends. With `leave` nothing is told to roscpp, whose destructors wait for the master.
  void drop(bool leave) {
    if (leave) leave_behind(std::move(updater_));
    updater_.reset();
  }

 private:
  struct Newest {
    std::vector<DiagnosticItem> items;
    std::chrono::steady_clock::time_point at;

    std::vector<DiagnosticItem> aged(std::optional<Span> limit,
                                     std::chrono::steady_clock::time_point awake_since) const {
      std::vector<DiagnosticItem> all = items;
      const Span age = std::chrono::steady_clock::now() - std::max(at, awake_since);
      if (!limit || age <= *limit) return all;
      for (DiagnosticItem& item : all)
        item.set(Health::error, fmt::format("no report from the sensor thread for {:.1f} s: {}", seconds(age),
                                            item.message));
      return all;
    }
  };
  struct Updater {
    diagnostic_updater::Updater updater;
    std::map<std::string, DiagnosticItem> items;
    std::set<std::string> names;  // that the updater knows

    void fill(const std::string& name, diagnostic_updater::DiagnosticStatusWrapper& status) const {
      if (const auto found = items.find(name); found != items.end()) to_ros(found->second, status);
    }
    void take(const DiagnosticItem& item) {
      const std::string& name = item.name;
      if (names.insert(name).second)
        updater.add(
            name, [this, name](diagnostic_updater::DiagnosticStatusWrapper& status) { fill(name, status); });
      items[item.name] = item;
    }
    /// Publishes nothing of what is no longer told.
    void forget() {
      for (auto name = names.begin(); name != names.end();) {
        const bool told = items.count(*name) > 0;
        if (!told) updater.removeByName(*name);
        name = told ? std::next(name) : names.erase(name);
      }
    }
  };

  const std::optional<Span> longest_age_;
  std::mutex mutex_;
  std::array<Newest, 2> newest_;
  std::unique_ptr<Updater> updater_;
};

}  // namespace lidard
