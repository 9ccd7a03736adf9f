// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "daemon/health/diagnostics.h"

namespace lidard {

/// A change of state for the operator.
struct Event {
  HostStamp at;  ///< on the host's clock
  std::string source;
  Health health = Health::ok;
  std::string text;         ///< a sentence, with the remedy unless health is ok
  bool logged = false;      ///< it is already in the log with more detail
  std::uint64_t count = 1;  ///< occurrences; `at` is the last one
  HostStamp first = at;     ///< the first occurrence
};

/// The changes of state of a running daemon, found by comparing the items of /diagnostics with the previous
/// ones. Changes of figures and items that are ok from the start are no events. Recurrences within ten
/// minutes are counted in one entry.
class Journal {
 public:
  /// `log` is called with every event, but at most `most_logged` times with one that recurs, so that a source
  /// with alternating states does not flood the log.
  explicit Journal(std::function<void(const Event&)> log) : log_(std::move(log)) {}

  /// Returns the items that became ERROR after they had been ok, as source and text without figures.
  std::vector<std::string> update(const std::vector<DiagnosticItem>& items, HostStamp now);
  void add(Event event);

  /// At most `most_events`, ordered by their last occurrence.
  const std::deque<Event>& events() const { return events_; }
  /// Number of older events that were dropped.
  std::uint64_t forgotten() const { return forgotten_; }

  static constexpr std::size_t most_events = 1000;
  static constexpr std::size_t most_logged = 5;

 private:
  struct Known {
    Health health = Health::ok;
    std::string text;  // without figures
  };

  std::function<void(const Event&)> log_;
  std::map<std::string, Known> known_;
  std::deque<Event> events_;
  std::uint64_t forgotten_ = 0;
};

}  // namespace lidard
