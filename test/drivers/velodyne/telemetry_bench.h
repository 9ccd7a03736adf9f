// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <string>
#include <vector>

#include "drivers/capture/pcap_source.h"
#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "drivers/velodyne/telemetry.h"

namespace lidard::test {

/// "$body*checksum" and the line end.
inline std::string sentence(const std::string& body) {
  unsigned sum = 0;
  for (const char c : body) sum ^= static_cast<unsigned char>(c);
  std::array<char, 8> end{};
  std::snprintf(end.data(), end.size(), "*%02X\r\n", sum);
  return "$" + body + end.data();
}

/// A telemetry packet written byte by byte.
struct TelemetryBytes {
  std::array<std::uint8_t, velodyne::telemetry_size> bytes{};

  TelemetryBytes& little(std::size_t at, std::uint32_t value, std::size_t length) {
    for (std::size_t i = 0; i < length; ++i) bytes[at + i] = static_cast<std::uint8_t>(value >> (8 * i));
    return *this;
  }
  TelemetryBytes& toh(double s) { return little(0xC6, static_cast<std::uint32_t>(s * 1e6 + 0.5), 4); }
  TelemetryBytes& pps(velodyne::Pps state) { return little(0xCA, static_cast<std::uint32_t>(state), 1); }
  TelemetryBytes& nmea(const std::string& text) {
    std::fill(bytes.begin() + 0xCE, bytes.begin() + 0xCE + 128, std::uint8_t{0});
    std::copy_n(text.begin(), std::min<std::size_t>(text.size(), 128), bytes.begin() + 0xCE);
    return *this;
  }
  ByteView view() const { return {bytes.data(), bytes.size()}; }
};

/// A receiver on the desk: keeps what comes out.
class TelemetryBench final : public FrameReceiver {
 public:
  explicit TelemetryBench(bool with_imu = false, ClockMode clock = ClockMode::arrival,
                          bool expect_pps = false) {
    model = *find_model("velodyne_vlp16");
    if (with_imu) model.messages.push_back(message_topic<ImuSample>());
    DriverConfig config;
    config.model = &model;
    config.frame_id = "roof";
    config.clock = clock;
    config.expect_pps = expect_pps;
    receiver = std::make_unique<velodyne::TelemetryReceiver>(config);
  }

  void scan(PlanarScan&) override { ADD_FAILURE() << "telemetry made a scan"; }
  void cloud(Cloud&) override { ADD_FAILURE() << "telemetry made a cloud"; }
  void message(const DeviceMessage& message) override {
    if (const auto* fix = std::get_if<GnssFix>(&message)) fixes.push_back(*fix);
    if (const auto* reference = std::get_if<TimeReference>(&message)) references.push_back(*reference);
    if (const auto* sample = std::get_if<ImuSample>(&message)) samples.push_back(*sample);
  }

  Reject give(ByteView bytes, Stamp arrival, HostStamp received = {}) {
    Packet packet;
    packet.payload = bytes;
    packet.arrival = arrival;
    packet.received = received;
    return receiver->receive(packet, *this, info);
  }
  /// All telemetry of a capture; returns how many packets.
  std::size_t play(const std::string& capture) {
    PcapSource source(capture);
    Packet packet;
    std::size_t count = 0;
    while (source.next(packet)) {
      if (packet.to.port != 8308) continue;
      EXPECT_EQ(give(packet.payload, packet.arrival), Reject::none);
      ++count;
    }
    return count;
  }
  std::string detail(const std::string& key) const {
    for (const auto& [name, value] : info.details) {
      if (name == key) return value;
    }
    return "(no such detail)";
  }

  Model model{};
  std::unique_ptr<velodyne::TelemetryReceiver> receiver;
  DeviceInfo info;
  std::vector<GnssFix> fixes;
  std::vector<TimeReference> references;
  std::vector<ImuSample> samples;
};

}  // namespace lidard::test
