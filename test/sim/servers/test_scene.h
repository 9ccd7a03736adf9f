// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "test/sim/servers/scene_file.h"
#include "test/sim/servers/simulate.h"

namespace lidard::sim {

/// A datagram kept with the truth that came with it.
struct KeptPacket {
  std::size_t sensor = 0;
  Stamp time;
  Endpoint from, to;
  std::vector<std::uint8_t> payload;
  bool measured = false;
  Measurement measurement;
  ByteView view() const { return {payload.data(), payload.size()}; }
};

inline std::vector<KeptPacket> all_packets(const Scene& scene) {
  std::vector<KeptPacket> kept;
  simulate(scene, [&](const SimPacket& packet) {
    kept.push_back({packet.sensor,
                    packet.time,
                    packet.from,
                    packet.to,
                    {packet.payload.begin(), packet.payload.end()},
                    packet.measurement != nullptr,
                    {}});
    if (packet.measurement != nullptr) kept.back().measurement = *packet.measurement;
    return true;
  });
  return kept;
}

/// One sensor in the middle of a square room of 10 m, standing still unless `extra` (more top-level keys)
/// says otherwise.
inline Scene room(const std::string& model, const std::string& sensor_keys, const std::string& extra = "",
                  const std::string& duration = "0.1") {
  return parse_scene("start: 2026-01-01T00:17:23.5Z\nduration: " + duration + "\nsensors:\n  it: {model: " +
                         model + ", from: '10.0.0.1:2368', to: '10.0.0.2:2368', " + sensor_keys +
                         "}\nobjects:\n"
                         "  - wall: {from: [5, -5], to: [5, 5], z: [-9, 9], reflectivity: 0.5}\n"
                         "  - wall: {from: [5, 5], to: [-5, 5], z: [-9, 9], reflectivity: 0.5}\n"
                         "  - wall: {from: [-5, 5], to: [-5, -5], z: [-9, 9], reflectivity: 0.5}\n"
                         "  - wall: {from: [-5, -5], to: [5, -5], z: [-9, 9], reflectivity: 0.5}\n" +
                         extra,
                     "room");
}

}  // namespace lidard::sim
