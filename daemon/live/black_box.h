// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/live/packet_ring.h"
#include "daemon/pipeline/sink.h"

namespace lidard {

/// Keeps the last packets of all sensors in memory and writes them to a capture when something went wrong, so
/// that the moments before can be replayed. Any thread may add() packets; the rest belongs to one thread. A
/// further thread lives while a capture is written; what is kept is kept meanwhile and afterwards.
class BlackBox {
 public:
  /// Takes the path of a capture that is written, or "error: " and why there is none.
  using Answer = std::function<void(const std::string&)>;

  /// `told`: a sentence for the log, good or bad; called by poll().
  BlackBox(BlackBoxConfig config, std::function<void(bool good, const std::string& sentence)> told);
  ~BlackBox();

  /// What is kept is kept if the memory stays as large.
  void configure(const BlackBoxConfig& config);
  void add(const Packet& packet);
  /// Something went wrong. It is written 5 s later, so that what follows is in it too; at most one capture is
  /// written in the time that one holds. The first capture that holds a `kind` stays when older ones are
  /// removed.
  void incident(Stamp now, const std::string& kind);
  /// Writes what is kept as soon as no other capture is being written.
  void dump(Answer answer) { asked_.push_back(std::move(answer)); }
  /// Time passed. Begins what is due, and reports what became of a capture. `step` is added to the stamps
  /// (HostClock::step()), `events()` is the text that is written beside.
  void poll(Stamp now, Span step, const std::function<std::string()>& events);
  /// Waits for a capture that is being written; who asked for one gets no answer any more.
  void finish();
  /// For /diagnostics; none if none is kept.
  std::optional<DiagnosticItem> item() const;

 private:
  struct Writing;
  void collect();
  std::string no_memory() const;
  bool is_first(const std::set<std::string>& kinds) const;
  std::string start(Stamp now, Span step, bool due, const std::function<std::string()>& events);

  bool is_on() const { return config_.seconds > 0; }

  BlackBoxConfig config_;  // guarded by mutex_, which the owner's thread need not lock to read
  const std::function<void(bool, const std::string&)> told_;
  std::mutex mutex_;
  std::shared_ptr<PacketRing> ring_;  // guarded by mutex_ as config_ is
  std::unique_ptr<Writing> writing_;
  std::vector<Answer> asked_;
  std::set<std::string> incidents_;  // kinds that are not written yet
  std::optional<Stamp> due_;         // when they will be
  Stamp pause_end_;
  std::set<std::string> kinds_;      // whose first captures stay:
  std::vector<std::string> firsts_;  // paths
  std::string trouble_;              // why the newest capture could not be written; empty: it could
};

}  // namespace lidard
