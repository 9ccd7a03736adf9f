// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/support/tcp_peer.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <stdexcept>

namespace lidard::test {
namespace {

sockaddr_in loopback(std::uint16_t port) {
  sockaddr_in out{};
  out.sin_family = AF_INET;
  out.sin_port = htons(port);
  out.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return out;
}

}  // namespace

TcpPeer::TcpPeer(std::uint16_t port, int backlog) : port_(port) { listen_again(backlog); }

TcpPeer::~TcpPeer() {
  close_client();
  stop_listening();
}

void TcpPeer::listen_again(int backlog) {
  listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  const int yes = 1;
  ::setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  sockaddr_in address = loopback(port_);
  socklen_t size = sizeof address;
  auto* raw = reinterpret_cast<sockaddr*>(&address);
  if (::bind(listener_, raw, size) != 0 || ::listen(listener_, backlog) != 0 ||
      ::getsockname(listener_, raw, &size) != 0)
    throw std::runtime_error("cannot listen on loopback");
  port_ = ntohs(address.sin_port);
}

void TcpPeer::stop_listening() {
  if (listener_ >= 0) ::close(listener_);
  listener_ = -1;
}

bool TcpPeer::accept() {
  const int client = ::accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (client < 0) return false;
  close_client();
  client_ = client;
  return true;
}

bool TcpPeer::send(const std::string& bytes) {
  return ::send(client_, bytes.data(), bytes.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(bytes.size());
}

std::string TcpPeer::read() {
  std::string out;
  std::array<char, 65536> buffer{};
  for (ssize_t got = 0; (got = ::recv(client_, buffer.data(), buffer.size(), MSG_DONTWAIT)) > 0;)
    out.append(buffer.data(), static_cast<std::size_t>(got));
  return out;
}

void TcpPeer::close_client() {
  if (client_ >= 0) ::close(client_);
  client_ = -1;
}

void TcpPeer::reset_client() {
  const linger at_once{1, 0};
  ::setsockopt(client_, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
  close_client();
}

bool TcpPeer::vanish() {
  const int yes = 1;
  if (::setsockopt(client_, IPPROTO_TCP, TCP_REPAIR, &yes, sizeof yes) != 0) return false;
  close_client();
  return true;
}

}  // namespace lidard::test
