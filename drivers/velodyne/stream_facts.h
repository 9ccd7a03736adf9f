// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

#include "drivers/driver.h"

namespace lidard::velodyne {

/// What the data packets of one sensor show of its settings, whatever the sensor itself may report.
class StreamFacts {
 public:
  void add(const Packet& packet);

  /// Arrival of the newest data packet; empty before the first.
  std::optional<Stamp> last_arrival() const { return last_arrival_; }
  /// Where the newest data packet was sent to.
  const Endpoint& destination() const { return destination_; }
  /// Its return mode as the sensor's web interface spells it; nullptr: none that is known.
  const char* returns() const;
  /// Mean over about the last second of data; empty before.
  std::optional<double> rpm() const { return rpm_; }

 private:
  void turn(std::uint32_t stamp_us, std::uint16_t azimuth);

  std::optional<Stamp> last_arrival_;
  Endpoint destination_;
  std::uint8_t mode_ = 0;
  std::optional<double> rpm_;
  bool has_last_ = false;
  std::uint32_t last_us_ = 0;
  std::uint16_t last_azimuth_ = 0;
  std::uint64_t turned_ = 0;   // 1/100 deg
  std::uint64_t time_us_ = 0;  // in which it turned so far
};

}  // namespace lidard::velodyne
