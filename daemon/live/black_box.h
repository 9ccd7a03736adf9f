// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/health/diagnostics.h"
#include "daemon/live/packet_ring.h"
#include "daemon/pipeline/sink.h"

namespace lidard {

/// Keeps the last packets of all sensors in memory and writes them to a capture after an error, for replay.
/// Any thread may add() packets; all other functions belong to one thread. A further thread runs while a
/// capture is written; packets are kept meanwhile and afterwards.
class BlackBox {
 public:
  /// Gets the path of the written capture, or "error: " and the reason.
  using Answer = std::function<void(const std::string&)>;

  /// `report` logs a sentence on success or failure; called by poll().
  BlackBox(BlackBoxConfig config, std::function<void(bool good, const std::string& sentence)> report);
  ~BlackBox();

  /// Keeps the packets if the memory size is unchanged.
  void configure(const BlackBoxConfig& config);
  void add(const Packet& packet);
  /// Reports an error. The capture is written 5 s later, so that it includes the following packets; at most
  /// once a minute, once per duration of a capture and `per_day` times a day, whatever fails. What lies in no
  /// capture is counted. The first capture of every `kind` is not removed with old ones.
  void incident(Stamp now, const std::string& kind);
  /// Writes the packets as soon as no other capture is being written.
  void dump(Answer answer) { asked_.push_back(std::move(answer)); }
  /// Advances the time: starts captures that are due and reports finished ones. `host` is `now` on the
  /// host's clock, which captures are stamped by; `events()` is the text for the file beside the capture.
  void poll(Stamp now, HostStamp host, const std::function<std::string()>& events);
  /// Waits for a capture that is being written; pending dump() calls get no answer.
  void finish();
  /// The item for /diagnostics; none if the black box is off.
  std::optional<DiagnosticItem> item() const;

 private:
  struct Writing;
  void collect();
  bool is_first(const std::set<std::string>& kinds) const;
  std::string used_up() const;
  std::string start(Stamp now, HostStamp host, bool due, const std::function<std::string()>& events);

  bool is_on() const { return config_.seconds > 0; }

  BlackBoxConfig config_;  // guarded by mutex_; the owner's thread may read without it
  const std::function<void(bool, const std::string&)> report_;
  std::mutex mutex_;
  std::optional<PacketRing> ring_;  // guarded by mutex_ as config_ is
  std::unique_ptr<Writing> writing_;
  std::vector<Answer> asked_;
  std::set<std::string> incidents_;  // kinds of the pending capture
  std::vector<Stamp> incident_times_;
  std::optional<Stamp> due_;  // time of the pending capture
  Stamp pause_end_;
  int of_day_ = 0;  // captures that errors started until day_end_
  Stamp day_end_;
  bool is_used_up_ = false;          // an error came beyond `per_day`
  std::uint64_t left_out_ = 0;       // errors in no capture
  std::set<std::string> kinds_;      // kinds with a protected first capture
  std::vector<std::string> firsts_;  // paths of protected captures
  std::string trouble_;              // error of the newest capture; empty: none
};

}  // namespace lidard
