// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <map>
#include <string>

#include "drivers/net/udp_source.h"

namespace lidard::test {

using std::chrono::milliseconds;

inline sockaddr_in ip(const std::string& address, std::uint16_t port) {
  sockaddr_in raw{};
  raw.sin_family = AF_INET;
  raw.sin_port = htons(port);
  inet_pton(AF_INET, address.c_str(), &raw.sin_addr);
  return raw;
}

/// A lidar's stand-in: sends from an address of the loopback network.
class Sender {
 public:
  explicit Sender(const std::string& from = "127.0.0.1") : fd_(socket(AF_INET, SOCK_DGRAM, 0)) {
    const int yes = 1;
    setsockopt(fd_, SOL_SOCKET, SO_BROADCAST, &yes, sizeof yes);
    const sockaddr_in local = ip(from, 0);
    EXPECT_EQ(bind(fd_, reinterpret_cast<const sockaddr*>(&local), sizeof local), 0) << from;
  }
  ~Sender() { close(fd_); }
  Sender(const Sender&) = delete;
  Sender& operator=(const Sender&) = delete;

  bool send(std::uint16_t port, const std::string& text, const std::string& to = "127.0.0.1") {
    const sockaddr_in target = ip(to, port);
    return sendto(fd_, text.data(), text.size(), 0, reinterpret_cast<const sockaddr*>(&target),
                  sizeof target) == static_cast<ssize_t>(text.size());
  }
  int fd() const { return fd_; }

 private:
  int fd_;
};

struct UdpBench {
  explicit UdpBench(UdpOptions options = {})
      : source(io, std::move(options), [this](const std::vector<Packet>& packets) {
          for (const Packet& packet : packets) {
            last = packet;
            ++by_sender[packet.from.address.to_string()];
            if (packet.stands_for > 1) stands_for += packet.stands_for;
            text = std::string(packet.payload.text());
            ++count;
          }
        }) {
    source.start();
  }
  void run(milliseconds span) {
    io.restart();
    io.run_for(span);
  }
  /// Runs until `done` or 20 s passed: machines that run tests are busy.
  template <class Done>
  bool run_until(Done done, milliseconds limit = milliseconds(20000)) {
    const auto end = std::chrono::steady_clock::now() + limit;
    while (!done() && std::chrono::steady_clock::now() < end) run(milliseconds(5));
    return done();
  }
  bool run_until_count(std::uint64_t n) {
    return run_until([&] { return count >= n; });
  }
  std::uint16_t port() const { return source.local_port(); }

  boost::asio::io_context io;
  Packet last;
  std::string text;
  std::map<std::string, int> by_sender;
  std::uint64_t stands_for = 0;  // packets of unknown senders
  std::uint64_t count = 0;
  UdpSource source;
};

}  // namespace lidard::test
