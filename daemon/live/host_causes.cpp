// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/host_causes.h"

#include <algorithm>

#include "daemon/health/network_health.h"
#include "daemon/health/sentences.h"
#include "drivers/model.h"

namespace lidard {
namespace {

/// Time without steps, for Alternation.
Stamp since_start(std::chrono::steady_clock::time_point at) {
  return Stamp{std::chrono::nanoseconds(at.time_since_epoch()).count()};
}

}  // namespace

HostCauses::HostCauses(const Config& config, const UdpPorts& ports) : ports_(ports) { configure(config); }

void HostCauses::configure(const Config& config) {
  sensors_ = config.sensors;
  kept_.clear();
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

/// Counts that show a cause stay for some seconds: rates of a second vary.
const std::optional<HostCounts>& HostCauses::latest_counts(std::size_t sensor) {
  constexpr auto lasts = std::chrono::seconds(5);
  auto& [kept, at] = kept_[sensor];
  auto counted = counts();
  const bool shows = counted && !host_hint(sensors_.at(sensor), *counted).empty();
  if (shows || now_->at - at > lasts) kept = std::move(counted), at = now_->at;
  return kept;
}

ConnectionStatus HostCauses::status(std::size_t sensor) {
  ConnectionStatus status;
  const SensorConfig& config = sensors_.at(sensor);
  if (!is_received(config)) return status;
  refresh();
  if (config.model->transport == Transport::udp) status.port = ports_.fault(config.ip_port);
  status.network = now_->network;
  status.has_route = config.ip_address && has_route_to(*config.ip_address);
  status.counts = latest_counts(sensor);
  return status;
}

}  // namespace lidard
