// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "drivers/driver.h"
#include "drivers/model.h"

namespace lidard {

/// The datagrams from one address to one local port, or the data of connections to one port of a device. The
/// configuration distinguishes senders by flows.
struct Flow {
  Transport transport = Transport::udp;
  IpAddress address;       ///< of the sender; unspecified: any sender
  std::uint16_t port = 0;  ///< destination port; for a connection the device's port

  /// "192.168.1.9 -> port 2368", "192.168.1.9:2112 over TCP".
  std::string to_string() const {
    if (transport == Transport::tcp) return Endpoint{address, port}.to_string() + " over TCP";
    return address.to_string() + " -> port " + std::to_string(port);
  }
  friend bool operator==(const Flow& a, const Flow& b) {
    return a.transport == b.transport && a.port == b.port && a.address == b.address;
  }
  friend bool operator<(const Flow& a, const Flow& b) {
    return std::tie(a.transport, a.address, a.port) < std::tie(b.transport, b.address, b.port);
  }
};

/// The flow that a packet belongs to.
inline Flow flow_of(const Packet& packet) {
  const bool connection = packet.transport == Transport::tcp;
  return {packet.transport, packet.from.address, connection ? packet.from.port : packet.to.port};
}
/// The flows of a device at `address`: data to (over TCP: from) `port` first, then telemetry and dialogue;
/// port 0: none.
inline std::vector<Flow> flows_of(const Model& model, const IpAddress& address, std::uint16_t port,
                                  std::uint16_t telemetry_port, std::uint16_t dialogue_port) {
  std::vector<Flow> flows = {{model.transport, address, port}};
  if (model.transport == Transport::tcp) return flows;
  if (telemetry_port != 0) flows.push_back({Transport::udp, address, telemetry_port});
  if (dialogue_port != 0) flows.push_back({Transport::tcp, address, dialogue_port});
  return flows;
}
/// The flows of a device whose telemetry and dialogue use the model's usual ports.
inline std::vector<Flow> flows_of(const Model& model, const IpAddress& address, std::uint16_t port) {
  return flows_of(model, address, port, model.telemetry_port, model.dialogue_port);
}

/// Finds the owner of a packet. A specified sender has priority over an unspecified one.
template <class Owner>
class FlowTable {
 public:
  /// The first owner of a flow keeps it.
  void add(const Flow& flow, const Owner& owner) { owners_.emplace(flow, owner); }
  /// nullptr: no owner.
  const Owner* find(const Flow& flow) const {
    auto found = owners_.find(flow);
    if (found == owners_.end()) found = owners_.find({flow.transport, IpAddress(), flow.port});
    return found == owners_.end() ? nullptr : &found->second;
  }
  const Owner* find(const Packet& packet) const { return find(flow_of(packet)); }
  /// The owner of the device that a chunk of a connection was sent to.
  const Owner* find_receiver(const Packet& packet) const {
    const auto found = owners_.find({packet.transport, packet.to.address, packet.to.port});
    return found == owners_.end() ? nullptr : &found->second;
  }

 private:
  std::map<Flow, Owner> owners_;
};

}  // namespace lidard
