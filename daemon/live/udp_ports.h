// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/health/diagnostics.h"
#include "daemon/pipeline/sink.h"
#include "drivers/net/udp_source.h"

namespace lidard {

/// The UDP ports of the sensors: one socket per port, shared by the sensors that send there.
class UdpPorts {
 public:
  UdpPorts(boost::asio::io_context& io, const Config& config, const UdpSource::Handler& handler);

  /// Applies another configuration. Unchanged ports continue to receive.
  void configure(const Config& config);
  void start();
  void stop();
  /// Passes on pending datagrams of busy ports.
  void catch_up();
  /// Call after interfaces or addresses of this host have changed.
  void interfaces_changed();
  /// Logs opened ports. Other changes are in add_diagnostics().
  void note_changes();
  /// One item per port.
  void add_diagnostics(std::vector<DiagnosticItem>& items) const;
  /// Datagrams received at all ports.
  std::uint64_t datagrams() const;
  /// Why a port cannot receive.
  UdpFault fault(std::uint16_t port) const;

 private:
  struct Port {
    std::uint16_t number = 0;
    std::unique_ptr<UdpSource> source;
    bool announced = false;
    std::uint64_t known_drops = 0;
    std::chrono::steady_clock::time_point dropped_at{};
  };

  boost::asio::io_context& io_;
  const UdpSource::Handler handler_;
  std::vector<Port> ports_;
  bool started_ = false;
};

}  // namespace lidard
