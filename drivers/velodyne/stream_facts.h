// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

#include "drivers/driver.h"
#include "drivers/velodyne/packet.h"

namespace lidard::velodyne {

/// Settings of a sensor as shown by its data packets.
class StreamFacts {
 public:
  void add(const Packet& packet) {
    if (packet.payload.size() != packet_size) return;
    const DataPacket data(packet.payload);
    if (data.flag(0) != flag_lasers_0_31 || data.azimuth(0) >= whole_turn) return;
    last_arrival_ = packet.arrival;
    destination_ = packet.to;
    mode_ = data.mode();
    turn(data.stamp_us(), data.azimuth(0));
  }

  /// Arrival of the newest data packet; empty before the first.
  std::optional<Stamp> last_arrival() const { return last_arrival_; }
  /// The destination of the newest data packet.
  const Endpoint& destination() const { return destination_; }
  /// Its return mode in the spelling of the web interface; nullptr: unknown.
  const char* returns() const {
    // VLS-128 only: UniBwTAS/velodyne (59).
    constexpr std::uint8_t dual_with_confidence = 0x3B;
    if (mode_ == static_cast<std::uint8_t>(ReturnMode::strongest)) return "Strongest";
    if (mode_ == static_cast<std::uint8_t>(ReturnMode::last)) return "Last";
    if (mode_ == static_cast<std::uint8_t>(ReturnMode::dual)) return "Dual";
    return mode_ == dual_with_confidence ? "Dual_conf" : nullptr;
  }

  /// Mean over about the last second of data; empty before.
  std::optional<double> rpm() const { return rpm_; }

 private:
  /// Measures the rotation; skips gaps, reordered packets and the overflow of the hour.
  void turn(std::uint32_t stamp_us, std::uint16_t azimuth) {
    // Less than half a turn at 1200 rpm, so that the angle is unambiguous.
    constexpr std::uint32_t longest_step_us = 20000;
    constexpr std::uint64_t window_us = 1000000;
    const std::uint32_t step_us = stamp_us - last_us_;
    if (has_last_ && step_us > 0 && step_us < longest_step_us) {
      turned_ += static_cast<std::uint64_t>((azimuth + whole_turn - last_azimuth_) % whole_turn);
      time_us_ += step_us;
    }
    has_last_ = true;
    last_us_ = stamp_us;
    last_azimuth_ = azimuth;
    if (time_us_ < window_us) return;
    constexpr double turns_per_count = 1.0 / whole_turn;
    rpm_ = static_cast<double>(turned_) * turns_per_count * 60e6 / static_cast<double>(time_us_);
    turned_ = 0;
    time_us_ = 0;
  }

  std::optional<Stamp> last_arrival_;
  Endpoint destination_;
  std::uint8_t mode_ = 0;
  std::optional<double> rpm_;
  bool has_last_ = false;
  std::uint32_t last_us_ = 0;
  std::uint16_t last_azimuth_ = 0;
  std::uint64_t turned_ = 0;   // 1/100 deg
  std::uint64_t time_us_ = 0;  // duration of turned_
};

}  // namespace lidard::velodyne
