// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "drivers/model.h"
#include "test/drivers/sick/safety/ms3_encoder.h"
#include "test/support/collector.h"

namespace lidard::test {

/// Of the default sample: 0.51306 deg of a turn in 30 ms, which the device rounds to 43 us.
constexpr Span beam_period{42755};

/// A safety scanner on the desk: sends samples to a driver and keeps the scans.
class SafetyBench final : public DriverBench {
 public:
  explicit SafetyBench(DriverConfig config = {})
      : DriverBench(
            config.model == nullptr ? std::string("sick_microscan3") : std::string(config.model->name),
            config) {}

  /// Sends the sample as the scan that ends at `arrival`.
  Reject send(const Ms3Sample& what, Stamp arrival) {
    Reject reason = Reject::none;
    for (const Bytes& datagram : ms3_datagrams(what.instance(), identification++)) {
      reason = receive(packet_of(datagram, arrival));
      arrival = arrival + std::chrono::microseconds(120);
    }
    return reason;
  }
  /// Keeps the name of the packet's device, if the packet has it.
  Reject receive(const Packet& packet) {
    const Verdict verdict = driver->receive(packet, *this);
    if (!verdict.device.empty()) device = verdict.device;
    return verdict.reject;
  }
  /// Sends the next of a row of scans, 30 ms after the last one.
  Reject send_next() {
    ++sample.sequence;
    ++sample.scan;
    now = now + std::chrono::milliseconds(sample.scan_time_ms);
    return send(sample, now);
  }

  std::string device;
  Ms3Sample sample;
  std::uint32_t identification = 1;
};

}  // namespace lidard::test
