// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/time.h"

namespace lidard {

/// When a merged scan is published. `complete`: as soon as every source that is alive has delivered. `rate`:
/// at a fixed rate. `trigger`: when one of the sources has delivered.
enum class Policy : std::uint8_t { complete, rate, trigger };

/// What is known of a source. `stale`: its next sweep is overdue, that is late by the deadline;
/// it contributes nothing. `lost`: silent for long.
enum class SourceState : std::uint8_t { never, ok, stale, lost };

struct ScheduleSettings {
  Policy policy = Policy::complete;
  double rate = 10;              ///< outputs per second, for policy `rate`
  std::size_t trigger = 0;       ///< the source that triggers, for policy `trigger`
  std::optional<Span> deadline;  ///< how long a source is waited for beyond the time it was due; default: 0.3
                                 ///< of the shortest period of the sources
  Span lost_after =
      std::chrono::milliseconds(400);  ///< of silence; a source is not lost before it is overdue
};

/// Decides when an output is due, and which sources have something to say in it. It has no clock: `now` is
/// the time that arrivals are stamped with, and may jump back when the input starts again.
class Scheduler {
 public:
  Scheduler(std::size_t sources, const ScheduleSettings& settings);

  /// A sweep came in. `end`: its last ray; `period`: what the device says of the time between sweeps, s, or
  /// 0.
  void delivered(std::size_t source, Stamp end, double period, Stamp now);
  /// True if an output is due; call done() after it was made.
  bool is_due(Stamp now);
  /// The next time at which an output may become due, or the state of a source changes, without a delivery.
  std::optional<Stamp> next_event() const;
  /// Which sources are to be used in an output that is made now, [source].
  const std::vector<char>& usable(Stamp now);
  /// The output was made.
  void done(Stamp now);
  /// Forgets everything (the input starts again).
  void reset();

  SourceState state(std::size_t source, Stamp now) const;
  /// s between sweeps of the source, as measured; 0: not known yet.
  double period(std::size_t source) const { return sources_[source].period; }
  /// Age of the source's newest sweep, from its last ray on.
  Span age(std::size_t source, Stamp now) const { return now - sources_[source].end; }
  /// How long something that is late is waited for.
  Span deadline() const;
  /// Outputs that were made without a source that was waited for in vain.
  std::uint64_t deadlines_missed() const { return deadlines_missed_; }
  /// How often the time jumped back.
  std::uint64_t restarts() const { return restarts_; }

 private:
  struct Source {
    bool seen = false;
    bool fresh = false;  // delivered since the last output
    bool used = false;   // in the last output
    bool back = false;   // it was lost before its newest sweep, which no output has shown
    Stamp arrival{};     // of the newest sweep
    Stamp end{};         // its last ray
    double period = 0;   // s
    double delay = 0;    // s from the last ray to the arrival, as usual
    int pauses = 0;      // in a row
  };
  void notice(Stamp now);
  static void learn_period(Source& source, double measured);
  /// Until when the source is waited for; later its next sweep is overdue.
  Stamp patience_end(const Source& source) const;
  Stamp lost_after(const Source& source) const;
  bool all_delivered(Stamp now) const;
  bool anything_usable(Stamp now) const;
  /// True if a source of the last output has become stale since, or one that was lost is back.
  bool has_news(Stamp now) const;
  Span rate_period() const { return span_from_seconds(1 / settings_.rate); }

  ScheduleSettings settings_;
  std::vector<Source> sources_;
  std::vector<char> usable_;
  std::optional<Stamp> first_;      // arrival of the first sweep of any source
  std::optional<Stamp> now_;        // the newest time heard of
  std::optional<Stamp> next_tick_;  // of policy `rate`
  std::uint64_t deadlines_missed_ = 0;
  std::uint64_t restarts_ = 0;
};

const char* to_string(Policy policy);
const char* to_string(SourceState state);

}  // namespace lidard
