// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "daemon/pipeline/status.h"
#include "drivers/net/udp_source.h"

namespace lidard {

/// The fault of a connection, with the remedy; empty: none. Likewise the others.
std::string fault_text(const TcpFault& fault, const Endpoint& device);
std::string fault_text(const UdpFault& fault, std::uint16_t port);

/// The state of a connection: "connected", or its fault.
std::string state_text(const TcpState& state, const Endpoint& device);
/// The warning that the receive buffer is smaller than requested; empty: it is large enough.
std::string buffer_text(const UdpStats& stats, std::uint16_t port);
/// True if this daemon receives the sensor itself.
bool is_received(const SensorConfig& sensor);
/// The fault of this host's network that affects a sensor; empty: none.
std::string host_trouble(const SensorConfig& sensor, const HostNetwork& network, bool has_route);
/// A hint that the reverse path filter drops packets; empty: it does not.
std::string path_filter_hint(const HostCounts& counts);
/// The likely reason why no datagram arrives from a sensor; empty: unknown.
std::string host_hint(const SensorConfig& sensor, const HostCounts& counts);
/// Why a sensor cannot be reached; empty: unknown.
std::string why_unreachable(const ConnectionStatus& status, const SensorConfig& sensor);

}  // namespace lidard
