// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/health/network_health.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "daemon/health/sentences.h"
#include "drivers/model.h"

namespace lidard {
namespace {

std::string why_not_connected(const std::string& device, int error) {
  if (error == ECONNREFUSED) return text<says::connection_refused>(device);
  // EHOSTUNREACH: no answer to ARP.
  if (error == ETIMEDOUT || error == EHOSTUNREACH || error == EHOSTDOWN) return text<says::no_answer>(device);
  if (error == ENETUNREACH || error == ENETDOWN) return text<says::no_way>(device, std::strerror(error));
  if (error == EMFILE || error == ENFILE) return text<says::no_socket>(device);
  return text<says::not_connected>(device, std::strerror(error));
}

std::string why_ended(const std::string& device, int error) {
  if (error == 0) return text<says::connection_closed>(device);
  if (error == ECONNRESET || error == EPIPE) return text<says::connection_reset>(device);
  if (error == ETIMEDOUT) return text<says::no_answer_any_more>(device);
  return text<says::connection_broke>(device, std::strerror(error));
}

std::string holder_text(const PortHolder& holder) {
  if (!holder.process.empty()) return text<says::held_by_program>(holder.program, holder.process);
  return holder.user.empty() ? "" : text<says::held_by_user>(holder.user);
}

std::string why_not_joined(const MulticastGroup& group, int error) {
  const std::string address = group.group.to_string();
  if (error == ENXIO) return text<says::group_without_interface>(address, group.interface);
  if (error != ENODEV) return text<says::group_not_joined>(address, std::strerror(error));
  if (group.interface.empty()) return text<says::group_without_route>(address);
  return text<says::group_without_address>(address, group.interface);
}

/// The interfaces that can receive a sensor's packets: those in its network, else that of its multicast
/// group.
std::vector<const HostInterface*> interfaces_of(const SensorConfig& sensor, const HostNetwork& network) {
  std::vector<const HostInterface*> found;
  for (const HostInterface& each : network.interfaces) {
    if (sensor.ip_address && each.reaches(*sensor.ip_address)) found.push_back(&each);
  }
  if (!found.empty() || sensor.interface.empty()) return found;
  for (const HostInterface& each : network.interfaces) {
    if (each.name == sensor.interface || each.address.to_string() == sensor.interface) found.push_back(&each);
  }
  return found;
}

/// A free address in the sensor's network, assuming a prefix of 24 bits.
std::string address_beside(IpAddress sensor) {
  sensor.bytes[3] = sensor.bytes[3] == 100 ? 101 : 100;
  return sensor.to_string() + "/24";
}

/// The interface that the sensor is probably connected to; one without an address is preferred.
std::string likely_interface(const HostNetwork& network) {
  const HostInterface* best = nullptr;
  for (const HostInterface& each : network.interfaces) {
    if (each.loopback) continue;
    const auto rank = [](const HostInterface& i) { return (i.has_link ? 2 : 0) + (i.prefix == 0 ? 1 : 0); };
    if (best == nullptr || rank(each) > rank(*best)) best = &each;
  }
  return best == nullptr ? "INTERFACE" : best->name;
}

std::string no_address(const IpAddress& sensor, const HostNetwork& network, bool has_route) {
  std::string known;
  for (const HostInterface& each : network.interfaces) {
    if (!each.loopback && each.prefix > 0) known += (known.empty() ? "" : ", ") + each.to_string();
  }
  if (known.empty()) known = text<says::none>();
  return has_route ? text<says::no_address_nor_router>(sensor.to_string(), known, address_beside(sensor),
                                                       likely_interface(network))
                   : text<says::no_address>(sensor.to_string(), known, address_beside(sensor),
                                            likely_interface(network));
}

double rate(std::uint64_t before, std::uint64_t now, double time_s) {
  return now > before && time_s > 0 ? static_cast<double>(now - before) / time_s : 0;
}

}  // namespace

std::string fault_text(const TcpFault& fault, const Endpoint& endpoint) {
  using Kind = TcpFault::Kind;
  const std::string device = endpoint.to_string();
  if (fault.kind == Kind::not_connected) return why_not_connected(device, fault.error);
  if (fault.kind == Kind::ended) return why_ended(device, fault.error);
  if (fault.kind == Kind::silent) return text<says::connection_silent>(device, seconds(fault.silence));
  return fault ? text<says::dialogue_failed>(device) : "";
}

std::string fault_text(const UdpFault& fault, std::uint16_t port) {
  const int error = fault.error;
  if (!fault) return {};
  if (fault.group.group != IpAddress()) return why_not_joined(fault.group, error);
  if (error == EADDRINUSE) return text<says::port_in_use>(port, holder_text(fault.holder));
  if (error == EACCES) return text<says::port_forbidden>(port);
  if (error == EMFILE || error == ENFILE) return text<says::no_socket>("port " + std::to_string(port));
  return text<says::port_not_readable>(port, std::strerror(error));
}

bool is_received(const SensorConfig& sensor) {
  return sensor.model != nullptr && sensor.packet_topic.empty();
}

std::string host_trouble(const SensorConfig& sensor, const HostNetwork& network, bool has_route) {
  if (!is_received(sensor)) return {};
  const auto interfaces = interfaces_of(sensor, network);
  // The state of the connection is more specific for a device behind a router.
  if (interfaces.empty() && has_route && sensor.model->transport == Transport::tcp) return {};
  const bool is_well = std::any_of(interfaces.begin(), interfaces.end(),
                                   [](const HostInterface* each) { return each->up && each->has_link; });
  if (is_well) return {};
  if (interfaces.empty()) return sensor.ip_address ? no_address(*sensor.ip_address, network, has_route) : "";
  const HostInterface& first = *interfaces.front();
  return first.up ? text<says::no_link>(first.to_string())
                  : text<says::interface_off>(first.to_string(), first.name);
}

std::string path_filter_hint(const HostCounts& counts) {
  const double dropped = rate(counts.before.dropped_by_path, counts.now.dropped_by_path, counts.time_s);
  return dropped < 1 ? "" : text<says::path_filter>(dropped);
}

std::string host_hint(const SensorConfig& sensor, const HostCounts& counts) {
  if (!is_received(sensor) || sensor.model->transport != Transport::udp) return {};
  if (std::string dropped = path_filter_hint(counts); !dropped.empty()) return dropped;
  // Well below what a sensor sends in its slowest mode: a rate at a limit would change the sentence to and
  // fro.
  const double enough = std::max(2.0, 0.1 * sensor.model->packets_per_s);
  const std::string who = sensor.ip_address ? sensor.ip_address->to_string() : "the sensor";
  const double unheard = rate(counts.before.without_port, counts.now.without_port, counts.time_s);
  if (unheard >= enough) return text<says::another_port>(unheard, sensor.ip_port, who);
  const double for_others = rate(counts.before.for_others, counts.now.for_others, counts.time_s);
  if (for_others >= enough) return text<says::another_address>(for_others, who);
  const auto interfaces = interfaces_of(sensor, counts.now);
  const auto earlier = interfaces_of(sensor, counts.before);
  if (interfaces.size() != 1 || earlier.size() != 1 || interfaces[0]->loopback) return {};
  const HostInterface& in = *interfaces[0];
  double came = rate(0, in.packets - earlier[0]->packets, counts.time_s);
  if (came < 2) return text<says::interface_silent>(in.to_string());
  // Those of other sensors are delivered.
  if (const double undelivered = rate(counts.before.undelivered, counts.now.undelivered, counts.time_s);
      counts.others_talk || undelivered >= enough)
    came = undelivered;
  return came < enough ? "" : text<says::only_others>(came, in.to_string(), who, sensor.ip_port, in.name);
}

std::string state_text(const TcpState& state, const Endpoint& device) {
  if (state.fault) return fault_text(state.fault, device);
  if (state.phase == TcpState::Phase::stopped) return text<says::stopped>();
  return state.is_first_attempt() ? text<says::connecting>() : text<says::connected>();
}

std::string buffer_text(const UdpStats& stats, std::uint16_t port) {
  if (stats.receive_buffer_got >= stats.receive_buffer_asked) return {};
  return text<says::buffer_small>(port, stats.receive_buffer_got, stats.receive_buffer_asked,
                                  1000 * seconds(stats.receive_buffer_lasts));
}

std::string why_unreachable(const ConnectionStatus& status, const SensorConfig& sensor) {
  if (status.port) return fault_text(status.port, sensor.ip_port);
  // A fault of this host's network explains that of the connection and is known earlier.
  std::string fault = status.network ? host_trouble(sensor, *status.network, status.has_route) : "";
  if (const std::string besides = status.counts ? path_filter_hint(*status.counts) : "";
      !fault.empty() && !besides.empty())
    return text<says::besides>(fault, besides);
  const bool is_known = !fault.empty() || status.tcp.phase == TcpState::Phase::connected;
  return is_known ? fault : state_text(status.tcp, {sensor.ip_address.value(), sensor.ip_port});
}

}  // namespace lidard
