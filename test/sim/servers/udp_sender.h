// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "core/base/bytes.h"
#include "core/base/time.h"
#include "drivers/address.h"

namespace lidard::sim {

/// Waits until a packet is due: the pace of the recording, on a clock that nobody sets. Sleeps until absolute
/// times, so that delays do not add up.
class Pacer {
 public:
  /// `rate`: times the pace of the recording; 0: never waits.
  explicit Pacer(double rate) : rate_(rate) {}
  /// The first call sets the origin and returns at once.
  void wait_until(Stamp time);
  /// The longest time (s) that a packet was late so far.
  double worst_delay() const { return worst_delay_; }

 private:
  double rate_;
  std::optional<Stamp> first_;
  std::int64_t begin_ns_ = 0;  // monotonic
  double worst_delay_ = 0;
};

/// Where packets really go, and from where.
struct Route {
  std::optional<IpAddress> to;                   ///< instead of the packet's own destination
  std::map<std::uint16_t, std::uint16_t> ports;  ///< destination port by the port in the capture
  std::map<IpAddress, IpAddress> sources;        ///< own address to send from, by the sender in the capture
};

/// The local address that stands for a sender. Every address 127.x.y.z is at hand on Linux: towards loopback
/// a sender a.b.c.d becomes 127.b.c.d unless the route says otherwise; elsewhere the system chooses (empty).
std::optional<IpAddress> local_source(const Route& route, const IpAddress& sender,
                                      const IpAddress& destination);

/// Sends datagrams, each sender of the capture through its own socket, so that a receiver can tell them
/// apart.
class UdpSender {
 public:
  explicit UdpSender(Route route) : route_(std::move(route)) {}
  ~UdpSender();
  UdpSender(const UdpSender&) = delete;
  UdpSender& operator=(const UdpSender&) = delete;

  /// Throws std::runtime_error when a socket cannot be had (address in use or not ours).
  void send(const Endpoint& from, const Endpoint& to, ByteView payload);

  struct Flow {
    std::string route;  ///< "192.168.0.21:6060 as 127.168.0.21:41234 to 127.0.0.1:6060"
    std::uint64_t packets = 0;
    std::uint64_t bytes = 0;
    std::uint64_t failed = 0;
    std::string error;  ///< why the last one failed
  };
  /// What was sent, by sender and destination port.
  const std::map<std::pair<Endpoint, std::uint16_t>, Flow>& flows() const { return flows_; }

 private:
  int socket_for(const Endpoint& from, const IpAddress& destination);

  Route route_;
  std::map<Endpoint, int> sockets_;
  std::map<std::pair<Endpoint, std::uint16_t>, Flow> flows_;
};

}  // namespace lidard::sim
