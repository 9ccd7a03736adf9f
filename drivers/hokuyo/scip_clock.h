// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <boost/circular_buffer.hpp>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/base/device_clock.h"
#include "core/base/time.h"
#include "drivers/hokuyo/scip_message.h"

namespace lidard::hokuyo {

/// The last turns of an evenly running motor: what a counter of ms showed when each began.
class TurnLine {
 public:
  struct Turn {
    std::int64_t number, tick, arrival;  ///< tick and arrival in ns
  };
  /// Adds the next turn; `period`: nominal, several turns may have passed. False if the motor did not turn
  /// evenly: numbers begin at 0 again.
  bool add(Span tick, Span period, Stamp arrival);
  void reset();
  std::size_t count() const { return turns_.size(); }
  const Turn& newest() const { return turns_.back(); }
  /// Turns between the newest and the one before.
  std::int64_t skipped() const { return skipped_; }
  /// Fits the line that deviates least from all ticks of the counter, if there are enough new ones; true if
  /// it did. A counter that showed n read n to n + 1: with every turn fewer lines fit, since the motor's beat
  /// with the counter shows where in a tick a turn began (as seqsense/urg_stamped src/scan_estimator_ust.cpp,
  /// which searches for 25 ms that become 24 or 26). Turns that no line fits are of another speed and are
  /// dropped.
  bool fit();
  /// Begin of a turn by the line, ns of the device.
  std::int64_t begin(std::int64_t number) const;
  /// Uncertainty of the line, ns: half of the range that the ticks leave open.
  std::int64_t uncertainty() const { return uncertainty_; }
  /// From the oldest to the newest.
  const boost::circular_buffer<Turn>& turns() const { return turns_; }

 private:
  double width(double period, double* lowest) const;
  void fit_once();

  boost::circular_buffer<Turn> turns_{1024};  // the beat of 100 ppm takes 400 turns
  std::int64_t skipped_ = 0;
  std::size_t fitted_ = 0;  // number of turns of the last fit; 0: none
  std::int64_t fitted_at_ = 0;
  std::int64_t base_number_ = 0, base_ = 0, uncertainty_ = 0;
  double period_ = 0;
};

/// Host times of a SCIP sensor's sweeps, from their arrivals; comparisons of both clocks (TM1) show the delay
/// on the way. The line through the arrivals is extended back to the comparison, so that a drift between the
/// clocks does not count as delay.
///
/// A counter of ms does not show where in a tick a sweep began; the line through the last turns does. Sensors
/// that send as soon as a sweep ends are mapped by that end. Those that send on a tick of their counter (UST:
/// urg_stamped, README and src/scan_estimator_ust.cpp) are mapped by the first tick after it: their arrivals
/// show when the counter ticked. Which of them a UST does shows where a motor's turns drift across the ticks.
/// Stamps in us need no line.
class ScipClock {
 public:
  /// `sends_on_tick`: as the model usually does, until its arrivals show something else.
  ScipClock(ClockMode mode, bool sends_on_tick)
      : mode_(mode), may_tick_(sends_on_tick), on_tick_(sends_on_tick), clock_(mode) {}

  struct Sweep {
    ScipStamp stamp;     ///< counter at step 0
    Span period{0};      ///< of a turn
    Span until_sent{0};  ///< from step 0 to the last step asked for: no answer leaves before
    Stamp arrival;
    bool evenly = true;  ///< one of an endless row; not an answer to a single request
  };
  /// The newest sweep of the first read of a stream: the clock begins with it, though older sweeps come
  /// first.
  void begin_with(const Sweep& sweep);
  /// True if a sweep was seen.
  bool ready() const { return clock_.ready(); }
  /// Host time of step 0. `skipped` gets the number of turns since the last sweep, less one.
  Stamp begin_of(const Sweep& sweep, std::int64_t& skipped);
  /// Compares the clocks of sensor and host: the counter was read between `sent` and `received`.
  void compare(ScipStamp stamp, Stamp sent, Stamp received);
  /// Uncertainty after the comparisons; nothing without one.
  std::optional<Span> uncertainty() const;
  /// From the end of a sweep to its arrival, as far as the comparisons showed it.
  std::optional<Span> measured_delay() const;
  /// True if a comparison was made, but is lost or too old now to show the delay.
  bool needs_comparison() const;
  /// A new connection: comparisons start again, and the next sweep does not follow the last one.
  void connection();
  void reset();
  std::uint64_t steps() const { return clock_.steps() + restarts_; }
  std::uint64_t wraps() const { return wraps_; }
  /// The clock behind the stamps.
  const DeviceClock& clock() const { return clock_; }

 private:
  Span unwrap(ScipStamp stamp, Stamp arrival);
  Span begin_by_line(const Sweep& sweep, Span read);
  Span sent_at(Span begin, const Sweep& sweep) const;
  int votes_for_ticks(const Sweep& sweep, std::int64_t processing) const;
  void find_tick(const Sweep& sweep);
  void observe_turn(const TurnLine::Turn& turn, const Sweep& sweep);
  void learn_delay(Stamp now);
  Stamp as_compared(Stamp begin, Span read, const Sweep& sweep) const;

  ClockMode mode_;
  bool may_tick_, on_tick_;
  DeviceClock clock_;
  TurnLine turns_;
  bool known_ = false;
  Span last_{0};
  Stamp last_arrival_;
  std::uint64_t restarts_ = 0, wraps_ = 0;
  // Bounds of host minus device from comparisons, ns, and when that was.
  bool compared_ = false, was_compared_ = false;
  std::int64_t lowest_ = 0, highest_ = 0;
  Span compared_device_{0};
  Stamp compared_at_;
  std::optional<std::int64_t> delay_;
  std::int64_t early_delay_ = 0;  // of the first seconds after the comparison
};

}  // namespace lidard::hokuyo
