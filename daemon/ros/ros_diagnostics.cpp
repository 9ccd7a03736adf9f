// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/ros_diagnostics.h"

#include <diagnostic_updater/diagnostic_updater.h>
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "daemon/ros/ros_callback_thread.h"
#include "daemon/ros/ros_convert.h"

namespace lidard {
namespace {

DiagnosticItem aged(DiagnosticItem item, Span age) {
  item.health = Health::error;
  item.message = fmt::format("no report from the sensor thread for {:.1f} s: {}", seconds(age), item.message);
  return item;
}

}  // namespace

struct RosDiagnostics::Updater {
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
      updater.add(name,
                  [this, name](diagnostic_updater::DiagnosticStatusWrapper& status) { fill(name, status); });
    }
    items[item.name] = item;
  }
};

RosDiagnostics::RosDiagnostics(std::optional<Span> longest_age) : longest_age_(longest_age) {}
RosDiagnostics::~RosDiagnostics() = default;

bool RosDiagnostics::set(const std::vector<DiagnosticItem>& items) {
  const std::lock_guard lock(mutex_);
  const bool news = items.size() != newest_.size() ||
                    !std::equal(items.begin(), items.end(), newest_.begin(),
                                [](const auto& a, const auto& b) { return a.health == b.health; });
  newest_ = items;
  set_at_ = std::chrono::steady_clock::now();
  return news;
}

void RosDiagnostics::start() {
  updater_ = std::make_unique<Updater>();
  // The hardware is another one for each status; "none" is what the updater wants to hear then.
  updater_->updater.setHardwareID("none");
}

void RosDiagnostics::publish(const std::vector<DiagnosticItem>& more) {
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

void RosDiagnostics::drop(bool leave) {
  if (leave) leave_behind(std::move(updater_));
  updater_.reset();
}

}  // namespace lidard
