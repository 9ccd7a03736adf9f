// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>

#include "daemon/commands/commands.h"
#include "daemon/pipeline/pipeline.h"
#include "drivers/capture/pcap_source.h"

namespace lidard {

/// Feeds a pipeline from captures at the requested pace.
class Player {
 public:
  Player(const ReplayOptions& options, MergedCapture& capture, Pipeline& pipeline);

  /// Called with the stamp of every packet before it is played (for /clock).
  std::function<void(Stamp)> on_time;
  /// Called for every packet and while there is nothing to do before `until`, which may have passed; returns
  /// at `until` or earlier.
  std::function<void(std::chrono::steady_clock::time_point until)> rest;

  /// Plays until the end or until `stop()` returns true.
  void play(const std::function<bool()>& stop);

  /// The time of the replay, once it has begun.
  Stamp now() const;
  /// Seconds of capture played so far.
  double played_s() const { return seconds(last_ - begin_); }
  /// Datagrams before `start`, not played.
  std::uint64_t skipped() const { return skipped_; }

 private:
  bool play_once(const std::function<bool()>& stop);
  /// Goes on at the same pace where the clock of the capture was set, or nothing came for long.
  void follow_clock(Stamp arrival);
  /// The clock that subscribers see does not go back by single packets.
  void show_time(Stamp stamp);
  bool wait_for(Stamp stamp, const std::function<bool()>& stop);
  std::chrono::steady_clock::time_point due(Stamp stamp) const;

  const ReplayOptions& options_;
  MergedCapture& capture_;
  Pipeline& pipeline_;
  bool started_ = false;
  Stamp begin_{};  // of the replay; moves with the clock of the capture
  Stamp first_{};  // of the first packet played
  Stamp last_{};
  Stamp next_{};
  Stamp shown_{};
  Span restamp_shift_{0};  // from the capture's stamps to those of the first round
  Span loop_shift_{0};     // from the capture's stamps to those of this round
  std::chrono::steady_clock::time_point wall_begin_;
  std::uint64_t skipped_ = 0;
};

}  // namespace lidard
