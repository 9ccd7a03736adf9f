// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/udp_ports.h"

#include <algorithm>
#include <map>
#include <utility>

#include "daemon/config/config.h"
#include "daemon/health/network_health.h"
#include "daemon/health/sentences.h"
#include "daemon/log/log.h"

namespace lidard {
namespace {

bool receives(const UdpState& state) {
  return state.phase == UdpState::Phase::receiving || state.phase == UdpState::Phase::partial;
}

/// Largest payload of UDP over IPv4.
constexpr std::size_t largest_datagram = 65507;

/// The model's need of receive buffer, as datagrams/s of usual size.
double load_of(const Model& model) {
  // A fragment occupies up to 2304 bytes.
  const double fragments = model.fragments_per_packet;
  return model.packets_per_s * (fragments > 1 ? 2 * fragments : 1);
}

/// The sockets needed: data ports, and telemetry ports.
std::map<std::uint16_t, UdpOptions> options_by_port(const Config& config) {
  std::map<std::uint16_t, UdpOptions> all;
  std::map<std::uint16_t, bool> open_to_all;
  for (const auto& sensor : config.sensors) {
    for (const Flow& flow : flows_of(sensor)) {
      if (flow.transport != Transport::udp) continue;
      const std::uint16_t number = flow.port;
      const bool fresh = all.find(number) == all.end();
      UdpOptions& options = all[number];
      options.port = number;
      options.max_datagram = largest_datagram;
      if (fresh) options.packets_per_s = 0;
      options.packets_per_s +=
          number == sensor.ip_port ? load_of(*sensor.model) : sensor.model->packets_per_s / 10;
      if (sensor.ip_address) {
        options.senders.push_back(*sensor.ip_address);
      } else {
        open_to_all[number] = true;
      }
      if (sensor.multicast_group) options.groups.push_back({*sensor.multicast_group, sensor.interface});
    }
  }
  for (auto& [number, options] : all) {
    if (open_to_all[number]) options.senders.clear();
  }
  return all;
}

}  // namespace

UdpPorts::UdpPorts(boost::asio::io_context& io, const Config& config, const UdpSource::Handler& handler)
    : io_(io), handler_(handler) {
  configure(config);
}

void UdpPorts::configure(const Config& config) {
  std::vector<Port> before = std::exchange(ports_, {});
  const auto wanted = options_by_port(config);
  for (Port& port : before) {
    if (wanted.count(port.number) == 0) port.source->stop();
  }
  for (const auto& [number, options] : wanted) {
    const auto same = std::find_if(before.begin(), before.end(),
                                   [number = number](const Port& port) { return port.number == number; });
    if (same != before.end()) {
      same->source->configure(options);
      ports_.push_back(std::move(*same));
      continue;
    }
    Port port;
    port.number = number;
    // Packets to a broadcast or group address also reach the handler with the configured port.
    port.source = std::make_unique<UdpSource>(io_, options, handler_);
    if (started_) port.source->start();
    ports_.push_back(std::move(port));
  }
}

void UdpPorts::start() {
  started_ = true;
  for (auto& port : ports_) port.source->start();
}

void UdpPorts::stop() {
  for (auto& port : ports_) port.source->stop();
}

void UdpPorts::catch_up() {
  for (auto& port : ports_) port.source->catch_up();
}

void UdpPorts::interfaces_changed() {
  for (auto& port : ports_) port.source->interfaces_changed();
}

void UdpPorts::note_changes() {
  for (auto& port : ports_) {
    const bool receiving = port.source->state().phase == UdpState::Phase::receiving;
    if (receiving && !std::exchange(port.announced, true)) log_info("listening on port {}", port.number);
    const std::uint64_t drops = port.source->stats().kernel_drops;
    if (std::exchange(port.known_drops, drops) != drops) port.dropped_at = std::chrono::steady_clock::now();
  }
}

void UdpPorts::add_diagnostics(std::vector<DiagnosticItem>& items) const {
  for (const auto& port : ports_) {
    const UdpState& state = port.source->state();
    const UdpStats& stats = port.source->stats();
    const std::string name = "port " + std::to_string(port.number);
    DiagnosticItem item{name, name};
    item.health = state.phase == UdpState::Phase::receiving ? Health::ok
                  : receives(state)                         ? Health::warn
                                                            : Health::error;
    item.is_up = receives(state);
    item.message = state.fault ? fault_text(state.fault, port.number) : text<says::listening>();
    if (std::string small = buffer_text(stats, port.number); item.health == Health::ok && !small.empty())
      item.set(Health::warn, std::move(small));
    if (stats.kernel_drops > 0 && std::chrono::steady_clock::now() - port.dropped_at < incident_lasts)
      item.set<says::lost_in_kernel>();
    item.add("Datagrams", stats.datagrams);
    item.add("Kernel drops", stats.kernel_drops);
    item.add("Truncated", stats.truncated);
    item.add("From unknown senders", stats.unknown_sampled + stats.unknown_filtered);
    item.add("Receive buffer (bytes)", stats.receive_buffer_got);
    items.push_back(std::move(item));
  }
}

std::uint64_t UdpPorts::datagrams() const {
  std::uint64_t all = 0;
  for (const auto& port : ports_) all += port.source->stats().datagrams;
  return all;
}

UdpFault UdpPorts::fault(std::uint16_t port) const {
  for (const auto& each : ports_) {
    if (each.number == port && !receives(each.source->state())) return each.source->state().fault;
  }
  return {};
}

}  // namespace lidard
