// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/bytes.h"
#include "test/sim/devices/velodyne.h"
#include "test/sim/servers/simulate.h"

namespace lidard::sim {

/// A Velodyne that stands in a closed room and what it is set to. What is left out is the product's default.
struct VelodyneSetup {
  std::string model = "velodyne_vlp16";  ///< one of velodyne_tables()
  std::string mode = "strongest";        ///< strongest, last, dual, dual_confidence
  std::optional<double> rpm;             ///< default: azimuths are exact on the wire
  std::optional<double> turn_deg;        ///< instead of rpm: turn per firing sequence (rest included)
  std::optional<AzimuthSector> fov;      ///< silent outside
  std::string timing;                    ///< VLS-128: a, b, c; HDL-64E: 48, 57.6
  std::optional<double> rest_spread_us;  ///< VLS-128 b: 0 makes its random rest constant, azimuths exact
  bool old_stamp = false;                ///< HDL-32E: stamp of the last firing, no factory bytes
  double start_azimuth_deg = 0;
  double telemetry_hz = 0;     ///< position packets too
  double divergence_mrad = 0;  ///< above 0 the poles' edges give two echoes; needed for dual
  double range_max = 0;        ///< m; 0: the product's. The room is 2.2 to 12.3 m away
  Span duration = std::chrono::milliseconds(250);
  Stamp start{1'767'226'643'500'000'000};        ///< 2026-01-01T00:17:23.5Z
  Span clock_offset{0};                          ///< the device's clock minus the true time
  Span latency = std::chrono::microseconds(20);  ///< from the last firing to the arrival
};

/// A packet as it arrives, with the truth of its slots.
struct SimulatedPacket {
  std::vector<std::uint8_t> payload;
  Stamp arrival;
  /// Slot 32 * block + k; empty for position packets. Blocks that hold no returns (dummies, confidence) have
  /// NaN in `wire`.
  std::vector<SlotTruth> slots;
  std::uint16_t port = 0;  ///< of sender and receiver: 2368, or 8308 for position packets

  ByteView view() const { return {payload.data(), payload.size()}; }
};

/// The room with that sensor. Walls, floor and ceiling, at a different distance in every direction, and six
/// poles at 2.3 to 4 m. The sensor's frame is the world's.
Scene velodyne_room(const VelodyneSetup& setup);

/// Where the distance on the wire puts a slot's point: the exact beam, the rounded distance (m, sensor
/// frame).
Eigen::Vector3d wire_point(const SlotTruth& slot, const VelodyneTable& table);

/// All packets of that time. Throws SceneError where the setup does not fit the model.
std::vector<SimulatedPacket> simulate_velodyne(const VelodyneSetup& setup);

}  // namespace lidard::sim
