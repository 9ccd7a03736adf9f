// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "daemon/ros/ros_callback_thread.h"
#include "daemon/ros/ros_component.h"

namespace lidard {

/// The components of a connection to ROS. Calls belong to the master thread, but for told().
class RosComponents {
 public:
  using Pointer = std::shared_ptr<RosComponent>;

  void add(Pointer component) { all_.push_back(std::move(component)); }
  /// Each first one gives its place to the second one: while ROS runs, when register_changes() is called.
  void replace(const std::vector<std::pair<Pointer, Pointer>>& changes, bool ros_runs) {
    for (const auto& [former, next] : changes) {
      all_.erase(std::remove(all_.begin(), all_.end(), former), all_.end());
      all_.push_back(next);
      if (!ros_runs) continue;
      const auto came = std::find(joining_.begin(), joining_.end(), former);
      if (came == joining_.end())
        leaving_.push_back(former);
      else
        joining_.erase(came);
      joining_.push_back(next);
    }
  }
  /// May wait for the master.
  void register_changes(RosCallbackThread& ros) {
    for (const Pointer& component : std::exchange(leaving_, {})) {
      component->disconnected();
      ros.drop(component.get());
    }
    for (const Pointer& component : std::exchange(joining_, {})) connect(*component, ros);
  }
  void connected(RosCallbackThread& ros) {
    for (const Pointer& component : all_) connect(*component, ros);
  }
  void disconnected() {
    for (const Pointer& component : all_) component->disconnected();
    for (const Pointer& component : std::exchange(leaving_, {})) component->disconnected();
    joining_.clear();
  }
  /// The services that a restarted master is to be told.
  std::vector<std::string> master_restarted() {
    std::vector<std::string> services;
    for (const Pointer& component : all_) {
      for (auto& service : component->master_restarted()) services.push_back(std::move(service));
    }
    return services;
  }
  /// Calls use(component) for each one; what it keeps is kept for that one.
  template <class Use>
  void for_each(RosCallbackThread& ros, Use use) {
    for (const Pointer& component : all_) {
      ros.keep_for(component.get());
      use(*component);
    }
  }
  /// Asks each one what it tells on /diagnostics.
  void ask() {
    std::vector<DiagnosticItem> told;
    for (const Pointer& component : all_) {
      for (auto& item : component->diagnostics()) told.push_back(std::move(item));
    }
    const std::lock_guard lock(mutex_);
    told_ = std::move(told);
  }
  /// What they told last, for any thread.
  std::vector<DiagnosticItem> told() const {
    const std::lock_guard lock(mutex_);
    return told_;
  }

 private:
  static void connect(RosComponent& component, RosCallbackThread& ros) {
    ros.keep_for(&component);
    component.connected(ros);
  }

  std::vector<Pointer> all_, leaving_, joining_;
  mutable std::mutex mutex_;
  std::vector<DiagnosticItem> told_;  // guarded by mutex_
};

}  // namespace lidard
