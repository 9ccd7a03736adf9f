// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/pipeline/sink.h"
#include "drivers/driver.h"

namespace lidard {

/// Keeps the last packets of all sensors in memory and writes them to a capture when something went wrong, so
/// that the moments before can be replayed. Any thread may add() packets; the rest belongs to one thread. A
/// further thread lives while a capture is written, with a memory of its own.
class BlackBox {
 public:
  /// `told`: a sentence for the log, good or bad; called by poll().
  BlackBox(BlackBoxConfig config, std::function<void(bool good, const std::string& sentence)> told);
  ~BlackBox();

  /// What is kept is kept if the memory stays as long and as large.
  void configure(const BlackBoxConfig& config);
  void add(const Packet& packet);
  /// What is kept is written in `delay`, so that what follows is in it too. `why`: a word for the file's
  /// name. Nothing while another one waits or is written. An error within the time that was written last is
  /// in there already.
  void write_on_error(Stamp now, Span delay);
  /// Writes at once. Returns the capture's path, or throws std::runtime_error. `step` as of poll().
  std::string write(Stamp now, Span step, const std::string& events);
  /// Time passed. Begins what is due, and tells what became of a capture. `step` is added to the stamps
  /// (HostClock::step()), `events()` is the text that is written beside.
  void poll(Stamp now, Span step, const std::function<std::string()>& events);
  /// For /diagnostics; none if none is kept.
  std::optional<DiagnosticItem> item() const;

 private:
  /// The newest packets, each with its bytes in a buffer that was used for an older one before.
  class Ring;
  struct Writing;
  void collect();
  void tell(bool good, const std::string& sentence);

  bool is_on() const { return config_.seconds > 0; }

  BlackBoxConfig config_;  // guarded by mutex_, which the owner's thread need not lock to read
  const std::function<void(bool, const std::string&)> told_;
  std::mutex mutex_;
  std::unique_ptr<Ring> ring_;  // guarded by mutex_
  std::unique_ptr<Writing> writing_;
  std::optional<Stamp> due_, written_;
  std::string trouble_;  // why the newest capture could not be written; empty: it could
};

}  // namespace lidard
