// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/tcp_connections.h"

#include <algorithm>

#include "daemon/pipeline/log.h"

namespace lidard {
namespace {

/// Longer than a driver waits for an answer (Patience::most), or for a motor that starts: it knows better.
constexpr Span first_frame_patience = std::chrono::seconds(12);
constexpr Span least_silence = std::chrono::seconds(1);

/// How long a stream may be silent: three scans, and those that are left out between two.
Span silence_of(const SensorConfig& sensor) {
  const int scans = 3 * (1 + sensor.driver.requests.skip.value_or(0));
  return std::max(least_silence, span_from_seconds(scans * sensor.model->frame_period));
}

bool is_connected(const TcpState& state) { return state.phase == TcpState::Phase::connected; }

std::string text_of(const TcpState& state, bool streams) {
  if (is_connected(state)) return "connected";
  if (!state.message.empty()) return state.message;
  if (state.phase == TcpState::Phase::stopped) return streams ? "stopped" : "not needed now";
  return first_attempt;
}

}  // namespace

TcpConnections::TcpConnections(boost::asio::io_context& io, const Config& config, LinkEvents events,
                               TcpOptions options)
    : io_(io), events_(std::move(events)), options_(options) {
  configure(config);
}

void TcpConnections::configure(const Config& config) {
  std::vector<std::unique_ptr<Link>> before = std::exchange(links_, {});
  for (std::size_t i = 0; i < config.sensors.size(); ++i) {
    const SensorConfig& sensor = config.sensors[i];
    if (sensor.model == nullptr) continue;
    const bool streams = sensor.model->transport == Transport::tcp;
    if (sensor.device_port() == 0 || sensor.driver.requests.listen_only) continue;
    const std::string text = to_yaml(sensor);
    const auto same =
        std::find_if(before.begin(), before.end(), [&](const auto& l) { return l && l->text == text; });
    if (same != before.end()) {
      (*same)->sensor = i;
      links_.push_back(std::move(*same));
      continue;
    }
    auto link = std::make_unique<Link>();
    link->sensor = i;
    link->text = text;
    link->name = sensor.name;
    link->streams = streams;
    link->device.port = sensor.device_port();
    link->silence = silence_of(sensor);
    if (streams) open(*link, sensor.ip_address.value());
    if (streams && started_) link->source->start();
    links_.push_back(std::move(link));
  }
  for (const auto& link : before) {
    if (link && link->source) link->source->stop();
  }
}

void TcpConnections::open(Link& link, const IpAddress& device) {
  link.device.address = device;
  TcpOptions options = options_;
  options.device = link.device;
  options.keep_up = link.streams;
  TcpHandlers handlers;
  handlers.receive = [this, &link](const Packet& packet) { events_.chunk(link.sensor, packet); };
  handlers.connected = [this, &link](Stamp now) { connected(link, now); };
  handlers.disconnected = [this, &link] { events_.disconnected(link.sensor); };
  link.source = std::make_unique<TcpSource>(io_, options, std::move(handlers));
}

void TcpConnections::connected(Link& link, Stamp now) {
  link.frames_before = events_.frames(link.sensor);
  if (link.streams) link.source->set_read_time_out(std::max(first_frame_patience, link.silence));
  events_.connected(link.sensor, now);
}

void TcpConnections::start() {
  started_ = true;
  for (const auto& link : links_) {
    if (link->streams) link->source->start();
  }
}

void TcpConnections::stop() {
  for (const auto& link : links_) {
    if (link->source) link->source->stop();
  }
}

void TcpConnections::look_again() {
  for (const auto& link : links_) {
    if (link->source) link->source->look_again();
  }
}

void TcpConnections::tick() {
  for (const auto& link : links_) {
    if (!link->streams || !is_connected(link->source->state())) continue;
    if (events_.frames(link->sensor) > link->frames_before) link->source->set_read_time_out(link->silence);
  }
}

void TcpConnections::log_first() {
  for (const auto& link : links_) {
    if (!link->source) continue;
    if (!is_connected(link->source->state()) || std::exchange(link->announced, true)) continue;
    log_info("{}: connected to {}", link->name, link->device.to_string());
  }
}

void TcpConnections::add_diagnostics(std::vector<DiagnosticItem>& items) const {
  for (const auto& link : links_) {
    if (!link->source) continue;
    const TcpState& state = link->source->state();
    const TcpStats& stats = link->source->stats();
    DiagnosticItem item{"link " + link->name, link->device.to_string()};
    item.message = text_of(state, link->streams);
    const bool idle = !link->streams && state.phase == TcpState::Phase::stopped && state.message.empty();
    if (!is_connected(state) && !idle && item.message != first_attempt)
      item.health = link->streams ? Health::error : Health::warn;  // data come without a dialogue
    item.awaited = events_.frames(link->sensor) == 0;
    item.add("Device", link->device.to_string());
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

Share TcpConnections::connected() const {
  Share connected;
  for (const auto& link : links_) {
    if (!link->streams) continue;
    ++connected.all;
    connected.good += is_connected(link->source->state()) ? 1U : 0U;
  }
  return connected;
}

TcpConnections::Link* TcpConnections::find(std::size_t sensor) {
  const auto found =
      std::find_if(links_.begin(), links_.end(), [&](const auto& link) { return link->sensor == sensor; });
  return found == links_.end() ? nullptr : found->get();
}

void TcpConnections::connect(std::size_t sensor, const IpAddress& device) {
  Link* link = find(sensor);
  if (link == nullptr) return;
  if (!link->source) open(*link, device);
  link->source->start();
}

void TcpConnections::send(std::size_t sensor, ByteView bytes) {
  Link* link = find(sensor);
  if (link != nullptr && link->source) link->source->send(bytes);
}

void TcpConnections::disconnect(std::size_t sensor, bool again) {
  Link* link = find(sensor);
  if (link == nullptr || !link->source) return;
  // A device that streams over TCP is of no use without its connection.
  link->source->disconnect(again || link->streams,
                           "the dialogue with " + link->device.to_string() +
                               " could not go on; it is begun again, the sensor's diagnostics say more");
}

std::string TcpConnections::trouble(std::size_t sensor) const {
  const Link* link = find(sensor);
  // What is wrong with this host explains what is wrong with the connection, and is known before it breaks.
  std::string host = events_.host_trouble ? events_.host_trouble(sensor) : std::string();
  const bool says_more = link != nullptr && link->streams && !is_connected(link->source->state());
  return host.empty() && says_more ? text_of(link->source->state(), true) : host;
}

std::string TcpConnections::hint(std::size_t sensor) const {
  return events_.host_hint ? events_.host_hint(sensor) : std::string();
}

}  // namespace lidard
