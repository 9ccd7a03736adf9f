// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/alternation.h"
#include "daemon/config/config.h"
#include "daemon/live/udp_ports.h"
#include "drivers/net/host_network.h"

namespace lidard {

/// The fault of this host's network that affects a sensor, with the remedy; empty: none.
std::string host_trouble(const SensorConfig& sensor, const HostNetwork& network, bool has_route);
/// Two readings of this host's network and the time between them.
struct HostCounts {
  const HostNetwork& before;
  const HostNetwork& now;
  double time_s = 0;
  bool others_talk = false;  ///< packets of other sensors may be among the received ones
};
/// A hint that the reverse path filter drops packets; empty: it does not.
std::string path_filter_hint(const HostCounts& counts);
/// The likely reason why no datagram arrives from a sensor; empty: unknown.
std::string host_hint(const SensorConfig& sensor, const HostCounts& counts);

/// Reads the state of this host's network when a sensor is silent: at most once per second, and
/// again after interfaces have changed.
class HostCauses {
 public:
  /// `ports` must outlive this.
  HostCauses(const Config& config, const UdpPorts& ports);

  void configure(const Config& config);
  void interfaces_changed() { stale_ = true; }
  /// As host_trouble(), or why the sensor's port cannot be opened. `sensor`: index in the configuration.
  std::string trouble(std::size_t sensor);
  std::string hint(std::size_t sensor);
  /// Call it often; reads the hardware addresses of the sensors once per second.
  void watch_addresses();
  /// Adds an item for every address that two devices have.
  void add_diagnostics(std::vector<DiagnosticItem>& items) const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Snapshot {
    HostNetwork network;
    std::uint64_t datagrams;  // of all local ports
    Clock::time_point at;
  };
  void refresh();
  std::optional<HostCounts> counts() const;

  std::vector<SensorConfig> sensors_;
  const UdpPorts& ports_;
  bool others_may_talk_ = false;  // there are senders whose packets ports_ does not count
  std::optional<Snapshot> before_, now_;
  std::map<std::size_t, std::pair<std::string, Clock::time_point>> hints_;  // by sensor, and when
  std::map<IpAddress, Alternation> addresses_;                              // of sensors
  Clock::time_point watched_{};
  bool stale_ = true;
};

}  // namespace lidard
