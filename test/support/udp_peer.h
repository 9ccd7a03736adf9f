// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>

#include "core/base/bytes.h"

namespace lidard::test {

/// A UDP socket of somebody else on this host.
class UdpPeer {
 public:
  UdpPeer() : fd_(socket(AF_INET, SOCK_DGRAM, 0)) {}
  ~UdpPeer() { close(fd_); }
  UdpPeer(const UdpPeer&) = delete;
  UdpPeer& operator=(const UdpPeer&) = delete;

  /// Holds the port from now on. False: another socket has it.
  bool take(std::uint16_t port) const {
    const sockaddr_in at = address(port, INADDR_ANY);
    return bind(fd_, reinterpret_cast<const sockaddr*>(&at), sizeof at) == 0;
  }
  /// Sends to a port of the loopback.
  void send(std::uint16_t port, ByteView bytes) const {
    const sockaddr_in to = address(port, INADDR_LOOPBACK);
    sendto(fd_, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
  }

 private:
  static sockaddr_in address(std::uint16_t port, std::uint32_t host) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(host);
    return address;
  }
  int fd_;
};

}  // namespace lidard::test
