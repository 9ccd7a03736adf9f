// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/time.h"

namespace lidard {

/// When a merged scan is published. `complete`: with each sweep of the slowest live source, as soon as the
/// sweep of every other one that is nearest in time is there. `rate`: at a fixed rate. `trigger`: when a
/// selected source has delivered.
enum class Policy : std::uint8_t { complete, rate, trigger };

/// State of a source. `stale`: its next sweep is overdue (late by the deadline); the source contributes
/// nothing. `lost`: no sweep for `lost_after`.
enum class SourceState : std::uint8_t { never, ok, stale, lost };

struct ScheduleSettings {
  Policy policy = Policy::complete;
  double rate = 10;              ///< outputs per second, for policy `rate`
  std::size_t trigger = 0;       ///< the triggering source, for policy `trigger`
  std::optional<Span> deadline;  ///< how long to wait for a source after its sweep is due; default: 0.3 of
                                 ///< the shortest period of the sources
  Span lost_after = std::chrono::milliseconds(400);  ///< silence; a source is not lost before it is overdue
};

/// Decides when an output is due and which sources it uses. The scheduler has no clock: `now` is the time
/// scale of arrivals and may jump back when the input starts again.
class Scheduler {
 public:
  Scheduler(std::size_t sources, const ScheduleSettings& settings);

  /// Reports the arrival of a sweep. `end`: its last ray; `period`: s between sweeps as the device reports
  /// it, or 0.
  void delivered(std::size_t source, Stamp end, double period, Stamp now);
  /// True if an output is due; call done() after publishing it.
  bool is_due(Stamp now);
  /// The next time at which an output may become due or a source changes its state without a delivery.
  std::optional<Stamp> next_event() const;
  /// The sources to use in an output that is made now, one flag per source.
  const std::vector<char>& usable(Stamp now);
  /// Reports that the output was made, or that it was left out.
  void done(Stamp now, bool is_left_out = false);
  /// Resets all state (the input starts again).
  void reset();

  SourceState state(std::size_t source, Stamp now) const;
  /// The same, but stale only after ten outputs without the source: a busy computer makes sweeps stale now
  /// and then for milliseconds.
  SourceState lasting_state(std::size_t source, Stamp now) const;
  /// Measured s between sweeps of the source; 0: not known yet.
  double period(std::size_t source) const { return sources_[source].period; }
  /// Age of the last ray of the source's newest sweep.
  Span age(std::size_t source, Stamp now) const { return now - sources_[source].end; }
  /// s by which the sweeps of the source come later than a period after their last ray: so much the deadline
  /// must exceed for the source to be waited for.
  double lateness(std::size_t source) const {
    return sources_[source].delay - std::min(sources_[source].delay, sources_[source].period);
  }
  /// How long to wait for a late sweep.
  Span deadline() const;
  /// Number of outputs that were made without a stale source.
  std::uint64_t deadlines_missed() const { return deadlines_missed_; }
  /// How often the time jumped back.
  std::uint64_t restarts() const { return restarts_; }

 private:
  struct Source {
    bool seen = false;
    bool fresh = false;  // delivered since the last output
    bool used = false;   // in the last output
    bool back = false;   // the newest sweep ends a loss and was in no output yet
    Stamp arrival{};     // of the newest sweep
    Stamp end{};         // last ray of the newest sweep
    double period = 0;   // s
    double delay = 0;    // s from the last ray to the arrival, smoothed
    int pauses = 0;      // consecutive
  };
  void advance(Stamp now);
  static void learn_period(Source& source, double measured);
  /// When the next sweep of the source is due.
  static Stamp next_arrival(const Source& source);
  /// End of the wait for the source; afterwards its next sweep is overdue.
  Stamp wait_end(const Source& source) const;
  Stamp lost_after(const Source& source) const;
  bool is_complete(Stamp now) const;
  /// True if the output of the leader's sweep is to wait for the next sweep of the source. `instant`: the
  /// middle of the sweeps that the source's should be near to.
  bool next_is_awaited(const Source& source, const Source& leader, Stamp instant, Stamp now) const;
  bool anything_usable(Stamp now) const;
  /// True if a source of the last output has become stale or a lost source has delivered again.
  bool sources_changed(Stamp now) const;
  Span rate_period() const { return span_from_seconds(1 / settings_.rate); }

  ScheduleSettings settings_;
  std::vector<Source> sources_;
  std::vector<char> usable_;
  std::vector<unsigned> outputs_without_;  // since the last one with the source
  std::optional<Stamp> first_;             // arrival of the first sweep of any source
  std::optional<Stamp> now_;               // the newest time
  std::optional<Stamp> next_tick_;         // of policy `rate`
  std::uint64_t deadlines_missed_ = 0;
  std::uint64_t restarts_ = 0;
};

const char* to_string(Policy policy);
const char* to_string(SourceState state);

}  // namespace lidard
