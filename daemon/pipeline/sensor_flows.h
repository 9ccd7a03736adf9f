// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <vector>

#include "daemon/config/config.h"
#include "drivers/flow.h"

namespace lidard {

/// What comes from a sensor over the network, its data first; without an address in a flow where anybody may
/// send it.
inline std::vector<Flow> flows_of(const SensorConfig& sensor) {
  if (sensor.model == nullptr) return {};
  std::vector<Flow> flows = flows_of(*sensor.model, sensor.ip_address.value_or(IpAddress()), sensor.ip_port,
                                     sensor.telemetry_port, sensor.device_port());
  const auto is_foreign = [&](const Flow& flow) {
    // Another node receives the datagrams; a device without address cannot be told by its connection.
    return flow.transport == Transport::udp ? !sensor.packet_topic.empty() : !sensor.ip_address;
  };
  flows.erase(std::remove_if(flows.begin(), flows.end(), is_foreign), flows.end());
  return flows;
}

}  // namespace lidard
