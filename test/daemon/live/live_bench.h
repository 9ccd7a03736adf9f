// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <string>
#include <vector>

#include "daemon/health/pipeline_health.h"
#include "daemon/live/tcp_connections.h"
#include "daemon/live/udp_ports.h"
#include "daemon/offline/no_transforms.h"
#include "daemon/pipeline/pipeline.h"
#include "drivers/net/wall_clock.h"
#include "test/daemon/pipeline/line_driver.h"

namespace lidard::test {

inline Stamp now_of_host() { return {wall_clock().ns}; }

/// A pipeline with its connections and ports, as the daemon has them.
struct LiveBench {
  explicit LiveBench(const Config& config, const TcpOptions& options = {})
      : pipeline(config, poses, sink),
        connections(io, config,
                    {[this](std::size_t sensor, Packet packet) {
                       packet.arrival = {packet.received.ns};
                       pipeline.chunk(sensor, packet);
                     },
                     [this](std::size_t sensor, HostStamp at) { pipeline.connected(sensor, {at.ns}); },
                     [this](std::size_t sensor) { pipeline.disconnected(sensor); },
                     [this](std::size_t sensor) { return pipeline.frames(sensor); },
                     [this](std::size_t) { return host; }},
                    options),
        ports(io, config, [this](std::vector<Packet>& packets) {
          for (Packet& packet : packets) {
            packet.arrival = {packet.received.ns};
            pipeline.packet(packet);
          }
        }) {
    pipeline.set_connections(&connections);
    connections.start();
    ports.start();
  }
  virtual ~LiveBench() = default;

  void run(std::chrono::milliseconds time) {
    const auto end = std::chrono::steady_clock::now() + time;
    do {
      io.restart();
      io.run_for(std::chrono::milliseconds(5));
      pipeline.tick(now_of_host());
      meanwhile();
    } while (std::chrono::steady_clock::now() < end);
  }
  template <class Condition>
  bool until(Condition done) {
    const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    while (!done()) {
      if (std::chrono::steady_clock::now() > limit) return false;
      run(std::chrono::milliseconds(5));
    }
    return true;
  }
  std::vector<DiagnosticItem> items() const {
    std::vector<DiagnosticItem> items;
    connections.add_diagnostics(items);
    return items;
  }
  std::string message(std::size_t item) const { return items().at(item).message; }
  /// What else happens while time passes.
  virtual void meanwhile() {}

  ConnectionStatus host;  // what HostCauses would find
  boost::asio::io_context io;
  NoTransforms poses;
  RecordingSink sink{false};
  Pipeline pipeline;
  TcpConnections connections;
  UdpPorts ports;
};

}  // namespace lidard::test
