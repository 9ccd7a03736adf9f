// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>

#include <memory>
#include <mutex>
#include <vector>

#include "core/base/host_clock.h"
#include "daemon/health/sentences.h"
#include "daemon/log/log.h"
#include "daemon/pipeline/sink.h"
#include "drivers/driver.h"
#include "drivers/net/wall_clock.h"

namespace lidard {

/// The host's clocks, shared by the threads of a daemon. Arrivals are converted to the time without steps.
/// The clocks are read at every call, so that a step is known before the first stamp after it is used.
class DaemonClock {
 public:
  /// The present time without steps.
  Stamp now() {
    const std::lock_guard lock(mutex_);
    return clock_.steady(read());
  }
  /// Converts a stamp of the host's clock to the time without steps.
  Stamp steady(HostStamp stamp) {
    const std::lock_guard lock(mutex_);
    const ClockReading reading = read();
    return clock_.steady(stamp, reading);
  }
  /// Converts when a batch of packets was received to their arrivals.
  void set_arrivals(std::vector<Packet>& packets) {
    const std::lock_guard lock(mutex_);
    const ClockReading reading = read();
    for (Packet& packet : packets) packet.arrival = clock_.steady(packet.received, reading);
  }
  /// Converts in both directions by the step known so far. Lives as long as it is used.
  std::shared_ptr<const ClockStep> step() const { return step_; }
  DiagnosticItem item() {
    const std::lock_guard lock(mutex_);
    const Stamp now = clock_.steady(read());
    DiagnosticItem item{"clock"};
    item.logged = true;
    item.set<says::clock_even>();
    item.values = {{"Steps", std::to_string(clock_.steps())},
                   {"Sum of Steps (s)", fmt::format("{:.3f}", seconds(clock_.step()))}};
    if (clock_.steps() > 0 && now - set_at_ < incident_lasts) item.set<says::clock_set>(seconds(last_step_));
    return item;
  }

 private:
  ClockReading read() {
    const ClockReading reading = read_clocks();
    if (const auto step = clock_.observe(reading)) {
      set_at_ = clock_.steady(reading);
      last_step_ = *step;
      step_->set(clock_.step());
      log_warn("the host's clock was set by {:+.3f} s; the stamps follow it in one step", seconds(*step));
    }
    return reading;
  }

  const std::shared_ptr<ClockStep> step_ = std::make_shared<ClockStep>();
  mutable std::mutex mutex_;
  HostClock clock_{read_clocks()};
  Stamp set_at_{};
  Span last_step_{0};
};

}  // namespace lidard
