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

/// The last turns of a motor that runs evenly: what a counter showed when each began, and when its scan came.
class TurnLine {
 public:
  struct Turn {
    std::int64_t number, tick, arrival;  ///< tick and arrival in ns
    std::int64_t begin = 0;              ///< ns of the device, where more is known than the tick
  };
  /// Takes the next turn; `period`: nominal, a whole part of it may have passed. False if the motor did not
  /// turn evenly: numbers begin at 0 again.
  bool add(Span tick, Span period, Stamp arrival);
  void reset() { turns_.clear(); }
  std::size_t count() const { return turns_.size(); }
  const Turn& newest() const { return turns_.back(); }
  /// Turns between the newest and the one before.
  std::int64_t skipped() const { return skipped_; }
  /// Least squares through the ticks: ns of a turn, and of the newest tick without its fraction.
  void fit(double& period, double& newest) const;
  /// From the oldest to the newest; what is known of their begins may be set.
  boost::circular_buffer<Turn>& turns() { return turns_; }
  const boost::circular_buffer<Turn>& turns() const { return turns_; }

 private:
  boost::circular_buffer<Turn> turns_{256};
  std::int64_t skipped_ = 0;
};

/// Host times of a SCIP sensor's sweeps, by listening; comparisons of both clocks (TM1) show what the way to
/// us takes. The line through the arrivals is followed back to the moment of the comparison, so that a drift
/// between the clocks does not count as a part of the way.
///
/// A counter of whole ms does not show where in one a sweep began. Sensors that send as soon as a sweep ends
/// tell by the arrival; the motor is the clock then, the counter only says which turn it is. Those that send
/// on a tick do not; there a line through the ticks of the last turns is the best guess. Stamps in us
/// need neither.
class ScipClock {
 public:
  ScipClock(ClockMode mode, bool sends_on_tick)
      : mode_(mode), on_tick_(sends_on_tick), clock_(mode), counter_clock_(mode) {}

  struct Sweep {
    ScipStamp stamp;     ///< counter at step 0
    Span period{0};      ///< of a turn
    Span until_sent{0};  ///< from step 0 to the last step asked for: no answer leaves before
    Stamp arrival;
    bool evenly = true;  ///< one of an endless row; not an answer to a single request
  };
  /// Host time of step 0. `skipped` gets the number of turns since the last sweep, less one.
  Stamp begin_of(const Sweep& sweep, std::int64_t& skipped);
  /// Compares the clocks of sensor and host: the counter was read between `sent` and `received`.
  void compare(ScipStamp stamp, Stamp sent, Stamp received);
  /// Width of what the comparisons leave open; nothing without one.
  std::optional<Span> uncertainty() const;
  /// From the end of a sweep to its arrival, as far as the comparisons showed it.
  std::optional<Span> measured_delay() const;
  /// True if a comparison was made, but is lost or too old by now to tell the delay that it was made for.
  bool needs_comparison() const;
  /// A new connection: comparisons start again, and the next sweep does not follow the last one.
  void connection();
  void reset();
  std::uint64_t steps() const { return clock_.steps() + restarts_; }
  double drift_ppm() const { return clock_.drift_ppm(); }

 private:
  Span unwrap(ScipStamp stamp, Stamp arrival);
  Span device_begin(const Sweep& sweep, Span read);
  Span by_motor(const Sweep& sweep);
  void learn_delay(const Sweep& sweep);
  Stamp as_compared(Stamp begin, Span read, const Sweep& sweep) const;

  ClockMode mode_;
  bool on_tick_;
  DeviceClock clock_;          // of begins and ends of turns
  DeviceClock counter_clock_;  // of the counter as it shows: for its drift
  TurnLine turns_;
  bool known_ = false;
  Span last_{0};
  Stamp last_arrival_;
  std::uint64_t restarts_ = 0;
  // The motor as a clock: begin of turn 0 and length of a turn, ns of the device.
  double turn_ = 0;
  std::int64_t base_ = 0;
  std::size_t chosen_at_ = 0;  // number of turns known when `turn_` was chosen; 0: not yet
  // Bounds of host minus device from comparisons, ns, and when that was.
  bool compared_ = false, was_compared_ = false;
  std::int64_t lowest_ = 0, highest_ = 0;
  Span compared_device_{0};
  Stamp compared_at_;
  std::optional<std::int64_t> delay_;
};

}  // namespace lidard::hokuyo
