// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/velodyne_controls.h"

namespace lidard {
namespace {

constexpr Span silent_after = std::chrono::seconds(1);

VelodyneReceived received(const velodyne::StreamFacts& facts, std::uint16_t port, Stamp now) {
  VelodyneReceived seen;
  seen.data = facts.last_arrival() && now - *facts.last_arrival() < silent_after;
  seen.destination = facts.destination();
  seen.mode = facts.mode();
  seen.rpm = facts.rpm();
  seen.listens_on = port;
  return seen;
}

}  // namespace

VelodyneControls::VelodyneControls(const Config& config) {
  for (const auto& sensor : config.sensors) {
    if (!sensor.control.read || !sensor.ip_address) continue;
    sensors_.push_back({sensor.name, {*sensor.ip_address, sensor.ip_port}, {}, nullptr});
    sensors_.back().http =
        std::make_unique<VelodyneHttp>("sensor " + sensor.name, *sensor.ip_address, sensor.control);
  }
}

void VelodyneControls::start() {
  for (auto& sensor : sensors_) sensor.http->start();
}

void VelodyneControls::stop() {
  for (auto& sensor : sensors_) sensor.http->stop();
}

void VelodyneControls::packet(const Packet& packet) {
  for (auto& sensor : sensors_) {
    if (packet.from.address == sensor.endpoint.address && packet.to.port == sensor.endpoint.port)
      sensor.facts.add(packet);
  }
}

void VelodyneControls::add_diagnostics(std::vector<DiagnosticItem>& items, Stamp now) const {
  for (const auto& sensor : sensors_) {
    items.push_back(velodyne_control_item(sensor.name, sensor.http->state(),
                                          received(sensor.facts, sensor.endpoint.port, now)));
  }
}

}  // namespace lidard
