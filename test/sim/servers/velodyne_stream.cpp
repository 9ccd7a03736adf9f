// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/servers/velodyne_stream.h"

#include <sstream>

#include "test/sim/servers/scene_file.h"

namespace lidard::sim {
namespace {

constexpr std::uint16_t data_port = 2368;

// A solid is hit from inside too: the box is walls, floor and ceiling. It is tilted, else a beam would see
// the floor equally far all around.
constexpr const char* room_objects =
    "  - box: {center: [1.3, -0.7, 0.4], size: [17, 12, 6.5], rpy_deg: [4, -3, 12], reflectivity: 0.5}\n"
    "  - cylinder: {center: [2.5, 1.1, 0], radius: 0.1, height: 4, reflectivity: 0.9}\n"
    "  - cylinder: {center: [3.4, -1.9, 0], radius: 0.15, height: 4, reflectivity: 0.05}\n"
    "  - cylinder: {center: [0.3, -2.4, 0], radius: 0.1, height: 4, reflectivity: 1.6}\n"
    "  - cylinder: {center: [-2.1, -1.2, 0], radius: 0.2, height: 4, reflectivity: 0.3}\n"
    "  - cylinder: {center: [-3.6, 1.5, 0], radius: 0.1, height: 4, reflectivity: 0.7}\n"
    "  - cylinder: {center: [0.4, 3.1, 0], radius: 0.15, height: 4, reflectivity: 0.1}\n";

void put_options(std::ostream& text, const VelodyneSetup& setup) {
  text << "options: {return_mode: " << setup.mode << ", start_azimuth_deg: " << setup.start_azimuth_deg
       << ", telemetry_hz: " << setup.telemetry_hz;
  if (setup.rpm) text << ", rpm: " << *setup.rpm;
  if (setup.turn_deg) text << ", turn_deg: " << *setup.turn_deg;
  if (!setup.timing.empty()) text << ", timing: " << setup.timing;
  if (setup.rest_spread_us) text << ", rest_spread_us: " << *setup.rest_spread_us;
  if (setup.old_stamp) text << ", old_stamp: true";
  if (setup.fov) {
    text << ", fov: {start_deg: " << setup.fov->start_deg << ", end_deg: " << setup.fov->end_deg << "}";
  }
  text << "}";
}

}  // namespace

Scene velodyne_room(const VelodyneSetup& setup) {
  std::ostringstream text;
  text.precision(17);
  text << "start: 2026-01-01T00:00:00Z\nduration: 1\nobjects:\n" << room_objects;
  text << "sensors:\n  it: {model: " << setup.model << ", from: '192.168.1.201:" << data_port
       << "', to: '192.168.1.77:" << data_port << "', divergence_mrad: " << setup.divergence_mrad << ", ";
  if (setup.range_max > 0) text << "range_max: " << setup.range_max << ", ";
  put_options(text, setup);
  text << "}\n";
  Scene scene = parse_scene(text.str(), "velodyne_room");
  scene.start = setup.start;
  scene.duration = setup.duration;
  scene.sensors.front().clock_offset = setup.clock_offset;
  scene.sensors.front().latency = setup.latency;
  return scene;
}

Eigen::Vector3d wire_point(const SlotTruth& slot, const VelodyneTable& table) {
  const Eigen::Vector3d origin(0, 0, table.lasers[slot.laser].z_offset_mm / 1000);
  return origin + (slot.xyz - origin) * (slot.wire / slot.exact);
}

std::vector<SimulatedPacket> simulate_velodyne(const VelodyneSetup& setup) {
  std::vector<SimulatedPacket> packets;
  simulate(velodyne_room(setup), [&](const SimPacket& packet) {
    packets.push_back({{packet.payload.begin(), packet.payload.end()}, packet.time, {}, packet.to.port});
    if (packet.measurement != nullptr) packets.back().slots = packet.measurement->slots;
    return true;
  });
  return packets;
}

}  // namespace lidard::sim
