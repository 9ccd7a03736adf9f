// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/host_causes.h"

#include <algorithm>

#include "daemon/health/sentences.h"
#include "drivers/model.h"

namespace lidard {
namespace {

bool is_received(const SensorConfig& sensor) {
  return sensor.model != nullptr && sensor.packet_topic.empty();
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

/// Time without steps, for Alternation.
Stamp since_start(std::chrono::steady_clock::time_point at) {
  return Stamp{std::chrono::nanoseconds(at.time_since_epoch()).count()};
}

}  // namespace

std::string host_trouble(const SensorConfig& sensor, const HostNetwork& network, bool has_route) {
  if (!is_received(sensor)) return {};
  const auto interfaces = interfaces_of(sensor, network);
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

HostCauses::HostCauses(const Config& config, const UdpPorts& ports) : ports_(ports) { configure(config); }

void HostCauses::configure(const Config& config) {
  sensors_ = config.sensors;
  hints_.clear();
  auto known = std::exchange(addresses_, {});
  for (const SensorConfig& each : sensors_) {
    if (is_received(each) && each.ip_address) addresses_[*each.ip_address] = known[*each.ip_address];
  }
  others_may_talk_ = config.elsewhere.has_sensors ||
                     std::any_of(sensors_.begin(), sensors_.end(), [](const SensorConfig& each) {
                       return is_received(each) && each.model->transport == Transport::tcp;
                     });
}

void HostCauses::watch_addresses() {
  const auto now = Clock::now();
  if (now - watched_ < std::chrono::seconds(1)) return;
  watched_ = now;
  const auto neighbours = read_neighbours();
  for (auto& [address, watch] : addresses_) {
    if (const auto found = neighbours.find(address); found != neighbours.end())
      watch.observe(found->second, since_start(now));
  }
}

void HostCauses::add_diagnostics(std::vector<DiagnosticItem>& items) const {
  for (const auto& [address, watch] : addresses_) {
    const std::string rivals = watch.both(since_start(Clock::now()));
    if (rivals.empty()) continue;
    DiagnosticItem item{"address " + address.to_string(), address.to_string()};
    item.set<says::two_devices>(address.to_string(), text<says::hardware_addresses>(rivals));
    items.push_back(std::move(item));
  }
}

void HostCauses::refresh() {
  constexpr auto fresh = std::chrono::milliseconds(900);
  const auto now = Clock::now();
  if (!stale_ && now_ && now - now_->at < fresh) return;
  // Counters of different interfaces cannot be compared.
  before_ = stale_ ? std::nullopt : std::move(now_);
  now_ = Snapshot{read_network(), ports_.datagrams(), now};
  stale_ = false;
}

std::optional<HostCounts> HostCauses::counts() const {
  constexpr auto longest = std::chrono::seconds(5);
  if (!before_ || now_->at - before_->at > longest) return std::nullopt;
  return HostCounts{before_->network, now_->network,
                    std::chrono::duration<double>(now_->at - before_->at).count(),
                    others_may_talk_ || now_->datagrams != before_->datagrams};
}

std::string HostCauses::trouble(std::size_t sensor) {
  const SensorConfig& config = sensors_.at(sensor);
  if (!is_received(config)) return {};
  if (config.model->transport == Transport::udp) {
    if (std::string port = ports_.trouble(config.ip_port); !port.empty()) return port;
  }
  refresh();
  const bool has_route = config.ip_address && has_route_to(*config.ip_address);
  // The state of the connection is more specific for a device behind a router.
  const bool is_remote = has_route && config.model->transport == Transport::tcp;
  if (is_remote && interfaces_of(config, now_->network).empty()) return {};
  std::string fault = host_trouble(config, now_->network, has_route);
  const auto counted = counts();
  const std::string dropped = counted && !fault.empty() ? path_filter_hint(*counted) : std::string();
  return dropped.empty() ? fault : text<says::besides>(fault, dropped);
}

/// A hint stays for some seconds without its cause: rates of a second vary.
std::string HostCauses::hint(std::size_t sensor) {
  refresh();
  constexpr auto lasts = std::chrono::seconds(5);
  const auto counted = counts();
  std::string now = counted ? host_hint(sensors_.at(sensor), *counted) : std::string();
  auto& [hint, at] = hints_[sensor];
  if (!now.empty() || now_->at - at > lasts) hint = std::move(now), at = now_->at;
  return hint;
}

}  // namespace lidard
