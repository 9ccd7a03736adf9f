// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "test/sim/servers/velodyne_stream.h"

namespace lidard::sim {

constexpr std::int64_t us = 1000;  // ns

/// That model and mode for so many ms.
inline VelodyneSetup setup_of(const std::string& model, const std::string& mode = "strongest", int ms = 20) {
  VelodyneSetup setup;
  setup.model = model;
  setup.mode = mode;
  setup.duration = std::chrono::milliseconds(ms);
  return setup;
}

/// ns from one slot's firing to another's.
inline std::int64_t after(const SimulatedPacket& packet, std::size_t slot, std::size_t from = 0) {
  return (packet.slots[slot].time - packet.slots[from].time).count();
}

/// Per block.
inline std::vector<int> flags(const SimulatedPacket& packet) {
  std::vector<int> list;
  for (std::size_t b = 0; b < 12; ++b) list.push_back(packet.view().le16(100 * b));
  return list;
}

/// Per block, 1/100 deg.
inline std::vector<int> azimuths(const SimulatedPacket& packet) {
  std::vector<int> list;
  for (std::size_t b = 0; b < 12; ++b) list.push_back(packet.view().le16(100 * b + 2));
  return list;
}

}  // namespace lidard::sim
