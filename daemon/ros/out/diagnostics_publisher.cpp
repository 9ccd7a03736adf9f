// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/out/diagnostics_publisher.h"

#include <fmt/format.h>
#include <ros/node_handle.h>
#include <ros/this_node.h>

#include <algorithm>
#include <utility>

#include "daemon/ros/master/wait_until.h"
#include "daemon/ros/messages/convert.h"

namespace lidard {

bool DiagnosticsPublisher::set(Worker worker, const std::vector<DiagnosticItem>& items) {
  const std::lock_guard lock(mutex_);
  Newest& newest = newest_.at(static_cast<std::size_t>(worker));
  const bool news = !std::equal(items.begin(), items.end(), newest.items.begin(), newest.items.end(),
                                [](const auto& a, const auto& b) { return a.health == b.health; });
  newest = {items, std::chrono::steady_clock::now()};
  return news;
}

void DiagnosticsPublisher::start() {
  publisher_ = ros::NodeHandle().advertise<diagnostic_msgs::DiagnosticArray>("/diagnostics", 1);
}

void DiagnosticsPublisher::publish(const std::vector<DiagnosticItem>& more, TimePoint awake_since) {
  if (!publisher_) return;
  std::vector<DiagnosticItem> items;
  {
    const std::lock_guard lock(mutex_);
    items = joined(aged(newest_[0], awake_since), aged(newest_[1], awake_since));
  }
  items.insert(items.end(), more.begin(), more.end());
  diagnostic_msgs::DiagnosticArray message;
  to_ros(items, ros::this_node::getName().substr(1), from_ros(ros::Time::now()), message);
  publisher_.publish(message);
}

void DiagnosticsPublisher::stop(bool leave) {
  if (leave) leave_behind(std::move(publisher_));
  publisher_ = {};
}

std::vector<DiagnosticItem> DiagnosticsPublisher::aged(const Newest& newest, TimePoint awake_since) const {
  std::vector<DiagnosticItem> all = newest.items;
  const Span age = std::chrono::steady_clock::now() - std::max(newest.at, awake_since);
  if (!longest_age_ || age <= *longest_age_) return all;
  for (DiagnosticItem& item : all)
    item.set(Health::error,
             fmt::format("no report from the sensor thread for {:.1f} s: {}", seconds(age), item.message));
  return all;
}

}  // namespace lidard
