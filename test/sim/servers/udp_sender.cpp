// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/servers/udp_sender.h"

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <stdexcept>

namespace lidard::sim {
namespace {

constexpr std::int64_t ns_per_s = 1'000'000'000;

std::int64_t monotonic_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * ns_per_s + now.tv_nsec;
}

socklen_t to_sockaddr(const Endpoint& endpoint, sockaddr_storage& storage) {
  storage = {};
  if (!endpoint.address.v6) {
    auto* v4 = reinterpret_cast<sockaddr_in*>(&storage);
    v4->sin_family = AF_INET;
    v4->sin_port = htons(endpoint.port);
    std::memcpy(&v4->sin_addr, endpoint.address.bytes.data(), 4);
    return sizeof(sockaddr_in);
  }
  auto* v6 = reinterpret_cast<sockaddr_in6*>(&storage);
  v6->sin6_family = AF_INET6;
  v6->sin6_port = htons(endpoint.port);
  std::memcpy(&v6->sin6_addr, endpoint.address.bytes.data(), 16);
  return sizeof(sockaddr_in6);
}

Endpoint local_endpoint(int socket) {
  sockaddr_storage storage{};
  socklen_t length = sizeof storage;
  Endpoint endpoint;
  if (getsockname(socket, reinterpret_cast<sockaddr*>(&storage), &length) != 0) return endpoint;
  if (storage.ss_family == AF_INET) {
    const auto* v4 = reinterpret_cast<const sockaddr_in*>(&storage);
    std::memcpy(endpoint.address.bytes.data(), &v4->sin_addr, 4);
    endpoint.port = ntohs(v4->sin_port);
  } else {
    const auto* v6 = reinterpret_cast<const sockaddr_in6*>(&storage);
    endpoint.address.v6 = true;
    std::memcpy(endpoint.address.bytes.data(), &v6->sin6_addr, 16);
    endpoint.port = ntohs(v6->sin6_port);
  }
  return endpoint;
}

bool is_loopback(const IpAddress& address) { return !address.v6 && address.bytes[0] == 127; }

}  // namespace

void Pacer::wait_until(Stamp time) {
  if (!first_) {
    first_ = time;
    begin_ns_ = monotonic_ns();
  }
  if (rate_ <= 0) return;
  const auto since = static_cast<double>((time - *first_).count()) / rate_;
  const std::int64_t due = begin_ns_ + static_cast<std::int64_t>(since);
  const timespec wake{static_cast<std::time_t>(due / ns_per_s), static_cast<long>(due % ns_per_s)};
  // What is due already is sent at once: at 40,000 packets/s each call of the system counts.
  std::int64_t now = monotonic_ns();
  for (; now < due; now = monotonic_ns()) clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &wake, nullptr);
  worst_delay_ = std::max(worst_delay_, static_cast<double>(now - due) * 1e-9);
}

std::optional<IpAddress> local_source(const Route& route, const IpAddress& sender,
                                      const IpAddress& destination) {
  const auto found = route.sources.find(sender);
  if (found != route.sources.end()) return found->second;
  if (!is_loopback(destination) || sender.v6) return std::nullopt;
  IpAddress local = sender;
  local.bytes[0] = 127;
  return local;
}

UdpSender::~UdpSender() {
  for (const auto& entry : sockets_) ::close(entry.second);
}

int UdpSender::socket_for(const Endpoint& from, const IpAddress& destination) {
  const auto found = sockets_.find(from);
  if (found != sockets_.end()) return found->second;
  const int fd = ::socket(destination.v6 ? AF_INET6 : AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd < 0) throw std::runtime_error(std::string("no socket: ") + std::strerror(errno));
  sockets_[from] = fd;
  const int on = 1;
  setsockopt(fd, SOL_SOCKET, SO_BROADCAST, &on, sizeof on);
  // The port stays the system's choice: the sender's own is often the one that the receiver listens on.
  const auto source = local_source(route_, from.address, destination);
  if (!source) return fd;
  sockaddr_storage storage;
  const socklen_t length = to_sockaddr({*source, 0}, storage);
  if (::bind(fd, reinterpret_cast<const sockaddr*>(&storage), length) != 0) {
    throw std::runtime_error("cannot send from " + source->to_string() + ": " + std::strerror(errno) +
                             "; name an address of this machine with --source-map " +
                             from.address.to_string() + "=ADDRESS");
  }
  return fd;
}

void UdpSender::send(const Endpoint& from, const Endpoint& to, ByteView payload) {
  const auto other_port = route_.ports.find(to.port);
  const Endpoint destination{route_.to.value_or(to.address),
                             other_port == route_.ports.end() ? to.port : other_port->second};
  const int fd = socket_for(from, destination.address);
  sockaddr_storage storage;
  const socklen_t length = to_sockaddr(destination, storage);
  const ssize_t sent =
      ::sendto(fd, payload.data(), payload.size(), 0, reinterpret_cast<const sockaddr*>(&storage), length);
  const int reason = errno;
  Flow& flow = flows_[{from, to.port}];
  if (sent < 0) {
    ++flow.failed;
    flow.error = std::strerror(reason);
  } else {
    ++flow.packets;
    flow.bytes += payload.size();
  }
  if (flow.route.empty()) {
    flow.route =
        from.to_string() + " as " + local_endpoint(fd).to_string() + " to " + destination.to_string();
  }
}

}  // namespace lidard::sim
