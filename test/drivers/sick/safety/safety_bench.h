// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "test/drivers/sick/safety/ms3_encoder.h"

namespace lidard::test {

/// Of the default sample: 0.51306 deg of a turn in 30 ms, which the device rounds to 43 us.
constexpr Span beam_period{42755};

/// A safety scanner on the desk: sends samples to a driver and keeps the scans.
class SafetyBench final : public DriverOutput {
 public:
  explicit SafetyBench(DriverConfig config = {}) {
    if (config.model == nullptr) config.model = find_model("sick_microscan3");
    config.frame_id = "laser";
    driver = config.model->make(config);
  }

  void scan(PlanarScan& scan) override {
    EXPECT_EQ(violation(scan), nullptr) << violation(scan);
    scans.push_back(scan);
  }
  void message(const DeviceMessage& message) override {
    if (const auto* state = std::get_if<DeviceState>(&message)) states.push_back(*state);
  }
  void extra_scan(std::string_view topic, PlanarScan& scan) override {
    EXPECT_EQ(violation(scan), nullptr) << violation(scan);
    if (topic == "beam_status") return beam_statuses.push_back(scan);
    EXPECT_EQ(topic, "intrusion");
    intrusions.push_back(scan);
  }
  void cloud(Cloud&) override { ADD_FAILURE() << "a planar scanner made a cloud"; }

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

  std::unique_ptr<Driver> driver;
  std::string device;
  std::vector<PlanarScan> scans;
  std::vector<PlanarScan> intrusions, beam_statuses;
  std::vector<DeviceState> states;
  Ms3Sample sample;
  Stamp now = ms3_epoch;
  std::uint32_t identification = 1;
};

}  // namespace lidard::test
