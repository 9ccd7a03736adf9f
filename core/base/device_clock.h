// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/time.h"

namespace lidard {

/// How a device's own time becomes host time.
enum class ClockMode : std::uint8_t {
  arrival,  ///< every packet is placed by its own arrival: truthful about each packet, with the network's
            ///< jitter; a packet that a stalled host read late is placed by the device's own clock
  smooth    ///< lower envelope of the arrivals over the last seconds: no jitter, follows drift
};

/// Maps the (unwrapped) clock of one device to host time by listening alone.
///
/// A packet can be late but never early, so the lowest of `arrival - device` over a window is the best guess
/// of the offset between the clocks; a line below the minima of several windows follows the drift. The line
/// has the likeliest slope for exponentially distributed delays and crystals of the usual accuracy. The
/// windows are short at first and grow, so that the stamps are right soon and quiet later. A counter that is
/// rounded down reads low, which has the effect of a late packet. The same packets give the same stamps.
///
/// Records without arrival times (all of one time, of whole seconds, or counted up) show as packets that are
/// early, and by more the longer the arrivals stand, apart from whole seconds. No network does that: a burst
/// is late. Such packets are held: they follow the device's clock from the first one on.
class DeviceClock {
 public:
  /// No stall is so long: the kernel stamps arrivals, and TCP ends a connection sooner. One such packet is a
  /// step (a device that was off for longer than the overflow its counter seems to have had).
  static constexpr Span longest_stall = std::chrono::seconds(10);

  explicit DeviceClock(ClockMode mode = ClockMode::smooth) : mode_(mode) {}

  /// A packet that could not leave before device time `device` arrived at `arrival`. Device time must be
  /// unwrapped (no overflow); a step of the device or the host clock beyond `step_limit` restarts the
  /// estimate.
  void observe(Span device, Stamp arrival);
  /// Host time of a device time near those observed. Epoch + device before the first observation.
  Stamp to_host(Span device) const {
    const std::int64_t offset = mode_ == ClockMode::arrival ? placed_ : predicted_offset(device.count());
    return Stamp{device.count() + (ready_ ? offset : 0)};
  }
  /// True if anything was observed yet.
  bool ready() const { return ready_; }
  /// Restarts caused by a clock step.
  std::uint64_t steps() const { return steps_; }
  /// What the offset gains, parts per million of the device's time (0 until enough was seen). It is negative
  /// for a device clock that is fast.
  double drift_ppm() const { return knows_drift() ? slope_ * 1e6 : 0; }
  /// True once the drift was measured.
  bool knows_drift() const { return knows_drift_; }
  /// Mean delay of the earliest packet of each window above the line. Zero before the first window.
  Span spread() const { return Span(spread_); }
  /// True if the packets have no arrival times, or had none for seconds.
  bool lacks_arrivals() const { return lacked_ || lacks_now(); }
  /// True if the newest packet's stamp follows the device's clock alone.
  bool is_held() const { return held_; }
  /// The same for long enough that it is no burst.
  bool lacks_now() const { return early_ && newest_ - run_.device > certain_after; }
  /// True if a packet would show nothing but the device's time: the arrivals stand, apart from whole seconds.
  bool stands(Span device, Stamp arrival) const;
  /// Host time of the newest packet's device time.
  Stamp newest() const { return to_host(Span(newest_)); }
  /// Forgets the offset, since the device's time began anew (a reboot). The drift stays as the first guess:
  /// the crystal is the same.
  void restart();
  /// Forgets everything, for another device.
  void reset();

 private:
  struct Minimum {
    std::int64_t device;
    std::int64_t offset;
  };
  void begin(std::int64_t device, std::int64_t arrival, std::int64_t owed);
  bool hold(std::int64_t device, std::int64_t arrival);
  void follow(std::int64_t device, std::int64_t arrival);
  void close_window(std::int64_t device, std::int64_t offset);
  void forget_former_rate();
  void halve();
  void fit();
  double likeliest_slope();
  std::int64_t predicted_offset(std::int64_t device) const {
    // Rounded without a call of the mathematical library: it is done for each firing sequence.
    const double gained = slope_ * static_cast<double>(device - base_device_);
    return base_offset_ + static_cast<std::int64_t>(gained + (gained < 0 ? -0.5 : 0.5));
  }

  ClockMode mode_;
  bool ready_ = false, knows_drift_ = false;
  std::uint64_t steps_ = 0;
  // Arrival since when every packet was beyond the step limit; 0: none. After a stall the delayed packets
  // arrive in one burst; after a step they arrive at their normal rate.
  std::int64_t late_since_ = 0;
  std::int64_t begun_ = 0, window_begin_ = 0;  // device time
  std::int64_t window_length_ = 0;
  Minimum window_{0, 0};
  static constexpr std::size_t max_minima = 40;
  Minimum minima_[max_minima]{};
  std::size_t minima_count_ = 0;
  std::int64_t base_device_ = 0;
  std::int64_t base_offset_ = 0;
  double slope_ = 0, expected_slope_ = 0, slope_deviation_ = 0;
  std::int64_t spread_ = 0;
  std::int64_t placed_ = 0;  // offset of the newest packet, in arrival mode
  /// The packets while the arrivals stood: the first one, and the offset that was known then, less owed_.
  struct Run {
    std::int64_t device, arrival, offset;
  };
  static constexpr std::int64_t certain_after = 300'000'000;
  Run run_{};
  /// How much lower the line was before a step, for a while. The step may have been a stall of the network;
  /// the burst at its end returns to the former line.
  std::int64_t owed_ = 0;
  std::int64_t newest_ = 0, newest_arrival_ = 0;  // of the newest packet, device time first
  std::int64_t newest_host_ = 0;                  // its stamp before a restart
  bool held_ = false, early_ = false, lacked_ = false;
};

}  // namespace lidard
