// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/health/diagnostics.h"
#include "daemon/pipeline/context.h"
#include "daemon/pipeline/sink.h"
#include "drivers/net/tcp_source.h"

namespace lidard {

/// Callbacks of TcpConnections; `sensor` is the sensor's index in the configuration.
struct ConnectionEvents {
  std::function<void(std::size_t sensor, const Packet& packet)> chunk;
  std::function<void(std::size_t sensor, HostStamp now)> connected;
  std::function<void(std::size_t sensor)> disconnected;
  /// Number of frames from the sensor's driver so far.
  std::function<std::uint64_t(std::size_t sensor)> frames;
  /// The sensor's port and this host's network.
  std::function<ConnectionStatus(std::size_t sensor)> host{};
  /// The time now.
  std::function<Stamp()> now{};
};

/// The TCP connections of the sensors: to devices that stream over TCP, and to other devices whose
/// drivers request a dialogue.
class TcpConnections final : public DeviceConnections {
 public:
  /// `options`: for every connection; the device is filled in.
  TcpConnections(boost::asio::io_context& io, const Config& config, ConnectionEvents events,
                 TcpOptions options = {});

  /// Applies another configuration. Connections of unchanged entries stay open.
  void configure(const Config& config);
  void start();
  void stop();
  /// Call after interfaces or addresses of this host have changed.
  void interfaces_changed();
  /// One item per connection.
  void add_diagnostics(std::vector<DiagnosticItem>& items) const;

  void connect(std::size_t sensor, const IpAddress& device) override;
  void send(std::size_t sensor, ByteView bytes) override;
  Stamp now() const override { return events_.now(); }
  void disconnect(std::size_t sensor, bool again) override;
  ConnectionStatus status(std::size_t sensor) const override;

 private:
  struct Connection {
    std::size_t sensor = 0;
    SensorConfig config;
    bool streams = false;  // false: only a dialogue
    Endpoint device;
    std::unique_ptr<TcpSource> source;
  };
  void open(Connection& connection, const IpAddress& device);
  Connection* find(std::size_t sensor);
  const Connection* find(std::size_t sensor) const { return const_cast<TcpConnections*>(this)->find(sensor); }

  boost::asio::io_context& io_;
  ConnectionEvents events_;
  TcpOptions options_;
  std::vector<std::unique_ptr<Connection>> connections_;
  bool started_ = false;
};

}  // namespace lidard
