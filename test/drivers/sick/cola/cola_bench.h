// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "drivers/model.h"
#include "test/sim/devices/cola_telegram.h"
#include "test/support/collector.h"

namespace lidard::test {

inline sim::SickChannel channel(const char* name, std::vector<std::uint16_t> values, bool wide = true) {
  return {name, 1, 0, -450000, 5000, wide, std::move(values)};
}

/// A scanner on the desk that speaks CoLa: sends telegrams to a driver and keeps what comes of them.
class ColaBench final : public DriverBench {
 public:
  explicit ColaBench(const char* model = "sick_lms1xx", DriverConfig config = {})
      : DriverBench(model, std::move(config)) {
    sample.start_us = 1'000'000;
    sample.transmit_us = 1'003'000;
    sample.channels = {{"DIST1", 1, 0, -450000, 5000, true, std::vector<std::uint16_t>(541, 2000)}};
  }

  void request(ByteView bytes) override { requests.emplace_back(bytes.begin(), bytes.end()); }

  Reject send(const std::vector<std::uint8_t>& bytes, std::uint64_t missing = 0, bool stream_start = false) {
    return feed({bytes.data(), bytes.size()}, stream_start, missing).reject;
  }
  Reject send_sample() { return send(sample.bytes(dialect)); }
  /// Sends the next of a row of scans, one period later.
  Reject send_next() {
    const std::uint32_t period_us = 100'000'000 / sample.scan_frequency;
    now = now + std::chrono::microseconds(period_us);
    sample.start_us += period_us;
    sample.transmit_us += period_us;
    ++sample.telegram_counter;
    ++sample.scan_counter;
    return send_sample();
  }
  /// Lets time pass in which nothing comes.
  void tick(double s) {
    now = now + span_from_seconds(s);
    driver->tick(now, *this);
  }

  sim::SickScan sample;
  sim::Cola dialect = sim::Cola::binary;
  std::vector<std::vector<std::uint8_t>> requests;
};

}  // namespace lidard::test
