// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "drivers/driver.h"
#include "drivers/net/udp_socket.h"

namespace boost::asio {
class io_context;
}

namespace lidard {

struct UdpStats {
  std::uint64_t datagrams = 0;         ///< passed to the handler
  std::uint64_t bytes = 0;             ///< their payloads
  std::uint64_t kernel_drops = 0;      ///< lost because the receive buffer was full
  std::uint64_t truncated = 0;         ///< longer than max_datagram
  std::uint64_t unknown_sampled = 0;   ///< from other senders and passed on as samples, 1 of 64
  std::uint64_t unknown_filtered = 0;  ///< from other senders and dropped by the kernel
  std::size_t receive_buffer_asked = 0, receive_buffer_got = 0;  ///< bytes, as in SO_RCVBUF
  Span receive_buffer_lasts{0};                                  ///< until it is full, while nobody reads
  std::uint64_t wakeups = 0;                                     ///< number of reads of the port
};

struct UdpState {
  enum class Phase : std::uint8_t {
    stopped,
    waiting,  ///< cannot receive now; retries
    partial,  ///< receives, but could not join every multicast group; retries
    receiving
  };
  Phase phase = Phase::stopped;
  UdpFault fault{};  ///< none while receiving
};

/// Receives datagrams from any number of senders on one local port, with the kernel's arrival stamps. A quiet
/// port is read at once. A busy port (more than 2000 datagrams/s) is read by a timer every millisecond, since
/// waking for every datagram costs more than reading it.
///
/// Never throws and never gives up: an error of the system (port in use, no such interface, ...) becomes a
/// state with its fault and is retried after 0.1 s, later up to 1 s.
class UdpSource {
 public:
  /// Gets the datagrams of one system call, in order; it may change them.
  using Handler = std::function<void(std::vector<Packet>&)>;

  /// `handler` is called from `io`.
  UdpSource(boost::asio::io_context& io, UdpOptions options, Handler handler);
  ~UdpSource();
  UdpSource(const UdpSource&) = delete;
  UdpSource& operator=(const UdpSource&) = delete;

  void start();
  /// No handler is called after this returns.
  void stop();
  /// Passes on what a busy port has received since its last timer.
  void catch_up();
  /// Call after interfaces or addresses have changed: joins groups again and retries failed steps at once.
  void interfaces_changed();

  /// Changes senders, groups and rates of an open socket. Port, address, share_port and max_datagram stay
  /// unchanged.
  void configure(UdpOptions options);

  const UdpState& state() const;
  const UdpStats& stats() const;
  /// The bound port; 0: none.
  std::uint16_t local_port() const;

 private:
  class Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace lidard
