// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/health/journal.h"

#include <algorithm>
#include <utility>

#include "daemon/health/sentences.h"

namespace lidard {
namespace {

std::string without_figures(std::string text) {
  text.erase(std::remove_if(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; }),
             text.end());
  return text;
}

/// An event that recurs within this time belongs to the same incident.
constexpr Span one_incident = std::chrono::minutes(10);

bool is_again(const Event& before, const Event& now) {
  return before.source == now.source && before.health == now.health && now.at >= before.at &&
         now.at - before.at < one_incident && without_figures(before.text) == without_figures(now.text);
}

}  // namespace

std::vector<std::string> Journal::update(const std::vector<DiagnosticItem>& items, HostStamp now) {
  std::vector<std::string> errors;
  const std::map<std::string, Known> before =
      std::exchange(known_, {});  // items that have gone are forgotten
  for (const DiagnosticItem& item : items) {
    const auto found = before.find(item.name);
    Known& known = known_[item.name] = found != before.end() ? found->second : Known();
    const std::string text = item.health == Health::ok ? "" : without_figures(item.message);
    if (known.health == item.health && known.text == text) continue;
    known.health = item.health;
    known.text = text;
    add({now, item.name, item.health, item.message, item.logged});
    if (item.health == Health::error && !item.awaited) errors.push_back(item.name + ": " + text);
  }
  return errors;
}

void Journal::add(Event event) {
  const auto before = std::find_if(events_.rbegin(), events_.rend(),
                                   [&](const Event& known) { return is_again(known, event); });
  if (before != events_.rend()) {
    event.count += before->count;
    event.first = before->first;
    events_.erase(std::next(before).base());
  }
  if (event.count < most_logged) log_(event);
  if (event.count == most_logged)
    log_({event.at, event.source, event.health, text<says::recurs>(event.text)});
  events_.push_back(std::move(event));
  if (events_.size() <= most_events) return;
  events_.pop_front();
  ++forgotten_;
}

}  // namespace lidard
