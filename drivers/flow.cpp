// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/flow.h"

namespace lidard {

std::string Flow::to_string() const {
  if (transport == Transport::tcp) return Endpoint{address, port}.to_string() + " over TCP";
  return address.to_string() + " -> port " + std::to_string(port);
}

Flow flow_of(const Packet& packet) {
  const bool connection = packet.transport == Transport::tcp;
  return {packet.transport, packet.from.address, connection ? packet.from.port : packet.to.port};
}

std::vector<Flow> flows_of(const Model& model, const IpAddress& address, std::uint16_t port,
                           std::uint16_t telemetry_port, std::uint16_t dialogue_port) {
  std::vector<Flow> flows = {{model.transport, address, port}};
  if (model.transport == Transport::tcp) return flows;
  if (telemetry_port != 0) flows.push_back({Transport::udp, address, telemetry_port});
  if (dialogue_port != 0) flows.push_back({Transport::tcp, address, dialogue_port});
  return flows;
}

}  // namespace lidard
