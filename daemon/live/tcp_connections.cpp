// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/tcp_connections.h"

#include <algorithm>

#include "daemon/health/network_health.h"
#include "daemon/health/sentences.h"
#include "daemon/log/log.h"

namespace lidard {
namespace {

/// Longer than a driver waits for an answer (Patience::most), for a starting motor or for a scan, so that the
/// driver's time limit applies first: it knows what the device was asked for.
constexpr Span longest_silence = std::chrono::seconds(12);

bool is_connected(const TcpState& state) { return state.phase == TcpState::Phase::connected; }

}  // namespace

TcpConnections::TcpConnections(boost::asio::io_context& io, const Config& config, ConnectionEvents events,
                               TcpOptions options)
    : io_(io), events_(std::move(events)), options_(options) {
  configure(config);
}

void TcpConnections::configure(const Config& config) {
  std::vector<std::unique_ptr<Connection>> before = std::exchange(connections_, {});
  for (std::size_t i = 0; i < config.sensors.size(); ++i) {
    const SensorConfig& sensor = config.sensors[i];
    if (sensor.model == nullptr) continue;
    const bool streams = sensor.model->transport == Transport::tcp;
    if (sensor.device_port() == 0 || sensor.driver.requests.listen_only) continue;
    const auto same =
        std::find_if(before.begin(), before.end(), [&](const auto& l) { return l && l->config == sensor; });
    if (same != before.end()) {
      (*same)->sensor = i;
      connections_.push_back(std::move(*same));
      continue;
    }
    auto connection = std::make_unique<Connection>();
    connection->sensor = i;
    connection->config = sensor;
    connection->streams = streams;
    connection->device.port = sensor.device_port();
    if (streams) open(*connection, sensor.ip_address.value());
    if (streams && started_) connection->source->start();
    connections_.push_back(std::move(connection));
  }
  for (const auto& connection : before) {
    if (connection && connection->source) connection->source->stop();
  }
}

void TcpConnections::open(Connection& connection, const IpAddress& device) {
  connection.device.address = device;
  TcpOptions options = options_;
  options.device = connection.device;
  options.keep_up = connection.streams;
  if (connection.streams) options.read_time_out = longest_silence;
  TcpHandlers handlers;
  handlers.receive = [this, &connection](const Packet& packet) { events_.chunk(connection.sensor, packet); };
  handlers.connected = [this, &connection](HostStamp now) { events_.connected(connection.sensor, now); };
  handlers.disconnected = [this, &connection] { events_.disconnected(connection.sensor); };
  connection.source = std::make_unique<TcpSource>(io_, options, std::move(handlers));
}

void TcpConnections::start() {
  started_ = true;
  for (const auto& connection : connections_) {
    if (connection->streams) connection->source->start();
  }
}

void TcpConnections::stop() {
  for (const auto& connection : connections_) {
    if (connection->source) connection->source->stop();
  }
}

void TcpConnections::interfaces_changed() {
  for (const auto& connection : connections_) {
    if (connection->source) connection->source->interfaces_changed();
  }
}

void TcpConnections::add_diagnostics(std::vector<DiagnosticItem>& items) const {
  for (const auto& connection : connections_) {
    if (!connection->source) continue;
    const TcpState& state = connection->source->state();
    const TcpStats& stats = connection->source->stats();
    DiagnosticItem item{"link " + connection->config.name, connection->device.to_string()};
    const bool idle = !connection->streams && state.phase == TcpState::Phase::stopped && !state.fault;
    item.message = idle ? text<says::not_needed>() : state_text(state, connection->device);
    if (!is_connected(state) && !idle && !state.is_first_attempt())
      item.health = connection->streams ? Health::error : Health::warn;  // data arrive without a dialogue
    item.awaited = events_.frames(connection->sensor) == 0;
    if (connection->streams) item.is_up = is_connected(state);
    item.add("Device", connection->device.to_string());
    item.add("Attempts", stats.attempts);
    item.add("Connections", stats.connects);
    item.add("Disconnections", stats.disconnects);
    item.add("Disconnections for silence", stats.silences);
    item.add("Bytes received", stats.received);
    item.add("Bytes sent", stats.sent);
    item.add("Requests dropped", stats.requests_dropped);
    items.push_back(std::move(item));
  }
}

TcpConnections::Connection* TcpConnections::find(std::size_t sensor) {
  const auto found = std::find_if(connections_.begin(), connections_.end(),
                                  [&](const auto& connection) { return connection->sensor == sensor; });
  return found == connections_.end() ? nullptr : found->get();
}

void TcpConnections::connect(std::size_t sensor, const IpAddress& device) {
  Connection* connection = find(sensor);
  if (connection == nullptr) return;
  if (!connection->source || !(connection->device.address == device)) open(*connection, device);
  connection->source->start();
}

void TcpConnections::send(std::size_t sensor, ByteView bytes) {
  Connection* connection = find(sensor);
  if (connection != nullptr && connection->source) connection->source->send(bytes);
}

void TcpConnections::disconnect(std::size_t sensor, bool again) {
  Connection* connection = find(sensor);
  if (connection == nullptr || !connection->source) return;
  // A device that streams over TCP needs its connection.
  connection->source->disconnect(again || connection->streams);
}

ConnectionStatus TcpConnections::status(std::size_t sensor) const {
  ConnectionStatus status = events_.host ? events_.host(sensor) : ConnectionStatus();
  const Connection* connection = find(sensor);
  if (connection != nullptr && connection->streams) status.tcp = connection->source->state();
  return status;
}

}  // namespace lidard
