// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "test/sim/devices/velodyne_tables.h"

namespace lidard::sim {

/// The UDP port of position packets.
constexpr std::uint16_t position_port = 8308;

/// What a position packet says.
struct PositionState {
  VelodyneTelemetry kind = VelodyneTelemetry::plain;
  std::uint32_t device_us = 0;  ///< since the hour of the device's clock
  bool pps_locked = false;
  Stamp utc;  ///< for the sentence
};

/// 512 bytes: time, PPS state, $GPRMC. An HDL-32E adds its inertial sensors (it stands level: 1 g along z),
/// new firmware its temperatures (41, 38 and 40 deg C).
std::vector<std::uint8_t> position_packet(const PositionState& state);

/// The sentence a GPS receiver sends for that time (UTC), with checksum and line end.
std::string gprmc(Stamp time, bool valid);

}  // namespace lidard::sim
