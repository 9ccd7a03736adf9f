// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <vector>

#include "core/base/alternation.h"
#include "daemon/config/config.h"
#include "daemon/live/udp_ports.h"
#include "daemon/pipeline/status.h"
#include "drivers/net/host_network.h"

namespace lidard {

/// Reads the state of this host's network when a sensor is silent: at most once per second, and
/// again after interfaces have changed.
class HostCauses {
 public:
  /// `ports` must outlive this.
  HostCauses(const Config& config, const UdpPorts& ports);

  void configure(const Config& config);
  void interfaces_changed() { stale_ = true; }
  /// But for the state of a TCP connection. `sensor`: index in the configuration.
  ConnectionStatus status(std::size_t sensor);
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
  const std::optional<HostCounts>& latest_counts(std::size_t sensor);

  std::vector<SensorConfig> sensors_;
  const UdpPorts& ports_;
  bool others_may_talk_ = false;  // there are senders whose packets ports_ does not count
  std::optional<Snapshot> before_, now_;
  std::map<std::size_t, std::pair<std::optional<HostCounts>, Clock::time_point>>
      kept_;                                    // by sensor, and when
  std::map<IpAddress, Alternation> addresses_;  // of sensors
  Clock::time_point watched_{};
  bool stale_ = true;
};

}  // namespace lidard
