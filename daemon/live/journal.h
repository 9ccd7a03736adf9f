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

/// Something changed that an operator wants to know of.
struct Event {
  Stamp at;  ///< on the host's clock
  std::string source;
  Health health = Health::ok;
  std::string text;         ///< a sentence, with the remedy unless health is ok
  bool logged = false;      ///< the log has it already, and more of it
  std::uint64_t count = 1;  ///< how often it happened, `at` being the last time,
  Stamp first = at;         ///< and this the first one
};

/// The changes of state of a running daemon: it compares the items of /diagnostics with what was known. A
/// figure alone is no news; neither is that something is well from the beginning. What happens again within
/// ten minutes is counted in one event.
class Journal {
 public:
  /// `told`: is called with each event when it is noted, but not with those of a source that changes to and
  /// fro (more than `most_told` within ten minutes), which would flood a log.
  explicit Journal(std::function<void(const Event&)> told) : told_(std::move(told)) {}

  /// Returns what went to ERROR and had worked since the start, each as its source and its text without
  /// figures.
  std::vector<std::string> update(const std::vector<DiagnosticItem>& items, Stamp now);
  void add(Event event);

  /// In the order in which they happened last, at most `most_events`.
  const std::deque<Event>& events() const { return events_; }
  /// How many older ones are forgotten.
  std::uint64_t forgotten() const { return forgotten_; }

  static constexpr std::size_t most_events = 1000;
  static constexpr std::size_t most_told = 10;

 private:
  struct Known {
    Health health = Health::ok;
    std::string text;        // without figures
    std::deque<Stamp> told;  // within the last ten minutes
    bool flaps = false;
  };
  bool is_to_be_told(const Event& event);

  std::function<void(const Event&)> told_;
  std::map<std::string, Known> known_;
  std::deque<Event> events_;
  std::uint64_t forgotten_ = 0;
};

}  // namespace lidard
