// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "daemon/pipeline/pipeline.h"
#include "drivers/capture/pcap_source.h"

namespace lidard {

/// Messages that were recorded, in the order of their times.
class TimedMessages {
 public:
  virtual ~TimedMessages() = default;
  /// When the next one was recorded; none at the end.
  virtual std::optional<Stamp> next() const = 0;
  /// Passes those up to `until` on; nullptr: drops them.
  virtual void feed(MessageReceiver* to, Stamp until) = 0;
};

/// How captures are played.
struct PlayOptions {
  double rate = 1;                                 ///< of the recorded pace; 0: as fast as possible
  bool loop = false;                               ///< repeats the captures with continuous stamps
  double start = 0;                                ///< s into the capture
  double duration = -1;                            ///< s; negative: to the end
  bool restamp = false;                            ///< shifts stamps so that the first packet comes now
  Span loop_gap = std::chrono::milliseconds(100);  ///< between the last packet of a round and the next round
};

/// Feeds a pipeline from captures at the requested pace.
class Player {
 public:
  Player(const PlayOptions& options, MergedCapture& capture, Pipeline& pipeline);

  /// Called with the stamp of every packet before it is played (for /clock).
  std::function<void(Stamp)> on_time;
  /// Called for every packet and while there is nothing to do before `until`, which may have passed; returns
  /// at `until` or earlier.
  std::function<void(std::chrono::steady_clock::time_point until)> rest;

  /// Plays until the end or until `stop()` returns true.
  void play(const std::function<bool()>& stop);
  /// Plays messages alone, from `start` on for `duration`.
  void play(TimedMessages& messages, const std::function<bool()>& stop);

  /// Plays the next packet; false at the end, or once `stop()` returns true. For callers that use what comes
  /// out packet by packet.
  bool step(const std::function<bool()>& stop);
  /// Hands on what is complete at the end.
  void finish() { pipeline_.finish(last_); }

  /// The time of the replay, once it has begun.
  Stamp now() const;
  /// Seconds of capture played so far.
  double played_s() const { return seconds(last_ - begin_); }
  /// From the capture's stamps to those of this round.
  Span shift() const { return loop_shift_; }
  /// Datagrams before `start`, not played.
  std::uint64_t skipped() const { return skipped_; }
  /// Why nothing was played; empty: something was, or the capture holds nothing.
  std::string why_nothing() const;

 private:
  bool play_once(const std::function<bool()>& stop);
  /// The next packet, valid until the next call; false at the end of the capture.
  bool next(Packet& packet);
  /// The packet that follows that at hand after `skipped` others; nullptr: the capture ends before.
  const Packet* peek(std::size_t skipped);
  /// Whether the packet at hand, which is `step` away from those before, is of another clock: the next ones
  /// continue by the former one.
  bool is_stray(Packet& packet, Span step);
  /// False: the clock of the capture was set before the packet, or nothing came for long; the replay
  /// continues at its pace. Removes from the arrival by how much another clock is ahead, and from continuous
  /// stamps the steps.
  bool follow_clock(Packet& packet);
  /// The clock that subscribers see does not go back by single packets.
  void show_time(Stamp stamp);
  bool wait_for(Stamp stamp, const std::function<bool()>& stop);
  std::chrono::steady_clock::time_point due(Stamp stamp) const;

  const PlayOptions& options_;
  MergedCapture& capture_;
  Pipeline& pipeline_;
  bool started_ = false;
  Stamp begin_{};  // of the replay; moves with the clock of the capture
  Stamp first_{};  // of the first packet played
  Stamp last_{};
  Stamp next_{};
  struct Held {
    explicit Held(const Packet& from) : packet(from), bytes(from.payload.begin(), from.payload.end()) {
      packet.payload = {bytes.data(), bytes.size()};
    }
    Packet packet;
    std::vector<std::uint8_t> bytes;
  };
  std::optional<Held> at_hand_;  // unless the capture holds it
  std::deque<Held> held_;        // read ahead
  /// Times of the capture in this round, without what is hidden.
  struct Round {
    Stamp begin{}, newest{};
    Span hidden{0};                           // steps that the arrivals do not show
    Span stray{0};                            // by which the newest packet of another clock was ahead
    bool is_read = false, is_played = false;  // a packet
  };
  Round round_;
  Span restamp_shift_{0};  // from the capture's stamps to those of the first round
  Span loop_shift_{0};     // see shift()
  std::chrono::steady_clock::time_point wall_begin_;
  std::uint64_t skipped_ = 0;
};

}  // namespace lidard
