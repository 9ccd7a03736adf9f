// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/base/bytes.h"
#include "test/sim/world/scene.h"

namespace lidard::sim {

/// The truth behind one packet (rotating lidars) or one scan (planar scanners).
struct Measurement {
  std::size_t sensor = 0;    ///< index into Scene::sensors
  std::uint64_t number = 0;  ///< counts this sensor's measurements from 0
  Stamp begin;               ///< first firing
  Stamp end;                 ///< last firing
  Pose2 vehicle;             ///< in the world, at `begin`
  std::vector<SlotTruth> slots;
};

/// A datagram or a piece of a TCP stream on its way. Everything is valid during the call only.
struct SimPacket {
  std::size_t sensor = 0;
  Stamp time;  ///< when it leaves
  Endpoint from, to;
  ByteView payload;
  bool tcp = false, to_device = false;
  const Measurement* measurement = nullptr;  ///< on the last datagram of a measurement
};

/// Drives through the scene and hands on the packets of all sensors in the order in which they leave. Ends
/// before the first packet that would leave at start + duration or later, or when `sink` returns false.
/// A pure function of the scene: every call gives the same bytes.
void simulate(const Scene& scene, const std::function<bool(const SimPacket&)>& sink);

/// The vehicle's frame at `from`, seen from the vehicle's frame at `to`: takes what a sensor saw at one time
/// to where it is seen from at another.
Pose vehicle_motion(const Scene& scene, Stamp from, Stamp to);

}  // namespace lidard::sim
