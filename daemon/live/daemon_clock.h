// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>

#include <functional>
#include <mutex>
#include <utility>
#include <vector>

#include "core/base/host_clock.h"
#include "daemon/pipeline/log.h"
#include "daemon/pipeline/sink.h"
#include "drivers/driver.h"
#include "drivers/net/wall_clock.h"

namespace lidard {

/// The host's clocks, shared by the threads of a daemon. Arrivals are converted to the time without steps.
/// The clocks are read at every call, so that a step is known before the first stamp after it is used.
class DaemonClock {
 public:
  /// `stepped` is called with HostClock::step() when its value changes, in the thread that detects the step.
  explicit DaemonClock(std::function<void(Span)> stepped) : stepped_(std::move(stepped)) {}

  /// The present time without steps.
  Stamp now() {
    const std::lock_guard lock(mutex_);
    return clock_.steady(read());
  }
  /// Converts a stamp of the host's clock to the time without steps.
  Stamp without_steps(Stamp stamp) {
    const std::lock_guard lock(mutex_);
    const ClockReading reading = read();
    return clock_.steady(stamp, reading);
  }
  /// The same for the arrivals of a batch of packets.
  void remove_steps(std::vector<Packet>& packets) {
    const std::lock_guard lock(mutex_);
    const ClockReading reading = read();
    for (Packet& packet : packets) packet.arrival = clock_.steady(packet.arrival, reading);
  }
  /// The host's clock at a time without steps.
  Stamp realtime(Stamp steady) const {
    const std::lock_guard lock(mutex_);
    return clock_.realtime(steady);
  }
  /// Sum of the steps of the host's clock.
  Span step() const {
    const std::lock_guard lock(mutex_);
    return clock_.step();
  }
  DiagnosticItem item() {
    const std::lock_guard lock(mutex_);
    const Stamp now = clock_.steady(read());
    DiagnosticItem item{"clock"};
    item.logged = true;
    item.message = "the host's clock runs evenly";
    item.values = {{"Steps", std::to_string(clock_.steps())},
                   {"Sum of Steps (s)", fmt::format("{:.3f}", seconds(clock_.step()))}};
    constexpr Span news = std::chrono::seconds(10);
    if (clock_.steps() > 0 && now - set_at_ < news)
      item.set(
          Health::warn,
          fmt::format("the host's clock was set by {:+.3f} s; keep it with chrony or ntpd, which turn its "
                      "rate instead",
                      seconds(last_step_)));
    return item;
  }

 private:
  ClockReading read() {
    const ClockReading reading = read_clocks();
    if (const auto step = clock_.observe(reading)) {
      set_at_ = clock_.steady(reading);
      last_step_ = *step;
      stepped_(clock_.step());
      log_warn("the host's clock was set by {:+.3f} s; the stamps follow it in one step", seconds(*step));
    }
    return reading;
  }

  const std::function<void(Span)> stepped_;
  mutable std::mutex mutex_;
  HostClock clock_{read_clocks()};
  Stamp set_at_{};
  Span last_step_{0};
};

}  // namespace lidard
