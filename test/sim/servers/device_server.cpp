// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/servers/device_server.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace lidard::sim {
namespace {

constexpr timespec nap{0, 500'000};

sockaddr_in to_sockaddr(const Endpoint& endpoint) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(endpoint.port);
  std::memcpy(&address.sin_addr, endpoint.address.bytes.data(), 4);
  return address;
}

}  // namespace

DeviceServer::DeviceServer(const Endpoint& listen_at, std::unique_ptr<TcpDevice> device)
    : address_(listen_at), device_(std::move(device)) {
  listen();
  thread_ = std::thread([this] { run(); });
}

DeviceServer::~DeviceServer() {
  stop_ = true;
  thread_.join();
  close_client(false);
  if (listener_ >= 0) ::close(listener_);
}

void DeviceServer::listen() {
  listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  const int on = 1;
  ::setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  sockaddr_in address = to_sockaddr(address_);
  if (::bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0 ||
      ::listen(listener_, 1) != 0) {
    const std::string reason = std::strerror(errno);
    ::close(listener_);
    listener_ = -1;
    throw std::runtime_error(address_.to_string() + ": " + reason + "; choose another address or port");
  }
  socklen_t size = sizeof address;
  ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
  port_ = address_.port = ntohs(address.sin_port);
}

void DeviceServer::run() {
  while (!stop_) {
    std::array<pollfd, 2> waiting{{{-1, POLLIN, 0}, {-1, POLLIN, 0}}};
    {
      // switch_off() and drop() close sockets in another thread.
      const std::lock_guard lock(mutex_);
      if (client_ < 0) waiting[0].fd = listener_;
      if (!hangs_) waiting[1].fd = client_;
    }
    ::ppoll(waiting.data(), waiting.size(), &nap, nullptr);
    const std::lock_guard lock(mutex_);
    if (client_ < 0 && listener_ >= 0) accept_client();
    if (client_ < 0 || hangs_) continue;
    read_client();
    write_client();
  }
}

void DeviceServer::accept_client() {
  client_ = ::accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (client_ < 0) return;
  const int on = 1;
  ::setsockopt(client_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  ++connections_;
  has_client_ = true;
  device_->connected(now_of_host());
}

void DeviceServer::read_client() {
  std::array<char, 4096> buffer{};
  while (client_ >= 0) {
    const ssize_t got = ::recv(client_, buffer.data(), buffer.size(), 0);
    if (got > 0) {
      device_->receive({buffer.data(), static_cast<std::size_t>(got)}, now_of_host());
    } else if (got == 0 || (errno != EAGAIN && errno != EINTR)) {
      close_client(false);
    } else {
      return;
    }
  }
}

void DeviceServer::write_client() {
  while (client_ >= 0) {
    if (pending_.empty()) {
      auto next = device_->next(now_of_host());
      if (!next) return;
      pending_ = std::move(next->bytes);
    }
    const ssize_t sent = ::send(client_, pending_.data(), pending_.size(), MSG_NOSIGNAL);
    if (sent < 0 && (errno == EAGAIN || errno == EINTR)) return;
    if (sent < 0) return close_client(false);
    bytes_sent_ += static_cast<std::uint64_t>(sent);
    pending_.erase(0, static_cast<std::size_t>(sent));
  }
}

void DeviceServer::close_client(bool reset) {
  if (client_ < 0) return;
  if (reset) {
    const linger abort{1, 0};
    ::setsockopt(client_, SOL_SOCKET, SO_LINGER, &abort, sizeof abort);
  }
  ::close(client_);
  client_ = -1;
  pending_.clear();
  has_client_ = false;
  device_->disconnected();
}

void DeviceServer::drop(bool reset) {
  const std::lock_guard lock(mutex_);
  close_client(reset);
}

void DeviceServer::switch_off() {
  const std::lock_guard lock(mutex_);
  close_client(true);
  if (listener_ >= 0) ::close(listener_);
  listener_ = -1;
}

void DeviceServer::switch_on() {
  const std::lock_guard lock(mutex_);
  if (listener_ < 0) listen();
}

}  // namespace lidard::sim
