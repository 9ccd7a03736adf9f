// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "daemon/pipeline/sink.h"

namespace lidard {

/// A change of state that an operator wants to know of.
struct Event {
  Stamp at;  ///< on the host's clock
  std::string source;
  Health health = Health::ok;
  std::string text;         ///< a sentence, with the remedy unless health is ok
  bool logged = false;      ///< the log has it already, and more of it
  std::uint64_t count = 1;  ///< occurrences; `at` is the last one
  Stamp first = at;         ///< the first occurrence
};

/// The changes of state of a running daemon, found by comparing the items of /diagnostics with the previous
/// ones. A change of figures alone is no event, nor is an item that is ok from the start. An event that
/// recurs within ten minutes is counted in one entry.
class Journal {
 public:
  /// `log` is called with each event, but at most `most_logged` times within ten minutes for one source: a
  /// source that changes to and fro must not flood the log.
  explicit Journal(std::function<void(const Event&)> told) : log_(std::move(told)) {}

  /// Returns the items that became ERROR after they had worked since the start, each as its source and its
  /// text without figures.
  std::vector<std::string> update(const std::vector<DiagnosticItem>& items, Stamp now);
  void add(Event event);

  /// At most `most_events`, ordered by their last occurrence.
  const std::deque<Event>& events() const { return events_; }
  /// How many older events were dropped.
  std::uint64_t forgotten() const { return forgotten_; }

  static constexpr std::size_t most_events = 1000;
  static constexpr std::size_t most_logged = 10;

 private:
  struct Known {
    Health health = Health::ok;
    std::string text;             // without figures
    std::deque<Stamp> logged_at;  // within the last ten minutes
    bool flaps = false;
  };
  bool should_log(const Event& event);

  std::function<void(const Event&)> log_;
  std::map<std::string, Known> known_;
  std::deque<Event> events_;
  std::uint64_t forgotten_ = 0;
};

}  // namespace lidard
