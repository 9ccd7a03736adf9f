// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "test/sim/devices/cola_telegram.h"

namespace lidard::test {

inline sim::SickChannel channel(const char* name, std::vector<std::uint16_t> values, bool wide = true) {
  return {name, 1, 0, -450000, 5000, wide, std::move(values)};
}

/// A scanner on the desk that speaks CoLa: sends telegrams to a driver and keeps what comes of them.
class ColaBench final : public DriverOutput {
 public:
  explicit ColaBench(const char* model = "sick_lms1xx", DriverConfig config = {}) {
    config.model = find_model(model);
    config.frame_id = "laser";
    driver = config.model->make(config);
    sample.start_us = 1'000'000;
    sample.transmit_us = 1'003'000;
    sample.channels = {{"DIST1", 1, 0, -450000, 5000, true, std::vector<std::uint16_t>(541, 2000)}};
  }

  void scan(PlanarScan& scan) override {
    EXPECT_EQ(violation(scan), nullptr) << violation(scan);
    scans.push_back(scan);
  }
  void cloud(Cloud& cloud) override { clouds.push_back(cloud); }
  void message(const DeviceMessage& message) override {
    if (const auto* state = std::get_if<DeviceState>(&message)) states.push_back(*state);
    if (const auto* imu = std::get_if<ImuSample>(&message)) imus.push_back(*imu);
  }
  void request(ByteView bytes) override { requests.emplace_back(bytes.begin(), bytes.end()); }
  void note(std::string_view sentence) override { notes.emplace_back(sentence); }
  void disconnect(bool again) override { ++(again ? reconnects : closes); }

  Reject send(const std::vector<std::uint8_t>& bytes, std::uint64_t missing = 0, bool stream_start = false) {
    Packet packet;
    packet.payload = {bytes.data(), bytes.size()};
    packet.arrival = now;
    packet.transport = Transport::tcp;
    packet.missing = missing;
    packet.stream_start = stream_start;
    return driver->receive(packet, *this).reject;
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
  bool has_warning(const std::string& part) const {
    for (const std::string& each : driver->info().warnings) {
      if (each.find(part) != std::string::npos) return true;
    }
    return false;
  }
  std::string detail(const std::string& key) const {
    for (const auto& each : driver->info().details) {
      if (each.first == key) return each.second;
    }
    return "(missing)";
  }
  const Counters& counters() const { return driver->counters(); }

  std::unique_ptr<Driver> driver;
  sim::SickScan sample;
  sim::Cola dialect = sim::Cola::binary;
  Stamp now{1'800'000'000'000'000'000};
  std::vector<PlanarScan> scans;
  std::vector<Cloud> clouds;
  std::vector<DeviceState> states;
  std::vector<ImuSample> imus;
  std::vector<std::vector<std::uint8_t>> requests;
  std::vector<std::string> notes;
  int reconnects = 0, closes = 0;
};

}  // namespace lidard::test
