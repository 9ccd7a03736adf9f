// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>

#include "drivers/driver.h"

namespace boost::asio {
class io_context;
}

namespace lidard {

struct TcpOptions {
  Endpoint device;
  Span connect_time_out = std::chrono::milliseconds(800);
  /// The connection is reopened after this time without a byte. 0: never.
  Span read_time_out{0};
  Span first_retry =
      std::chrono::milliseconds(100);  ///< from the start of one attempt to the next, then doubled
  Span last_retry = std::chrono::milliseconds(1000);
  /// False: one attempt per start(), and no new connection after the first one ended.
  bool keep_up = true;
  std::size_t send_limit = std::size_t{64} * 1024;  ///< bytes that are queued for a device that does not read
};

struct TcpStats {
  std::uint64_t attempts = 0;          ///< to connect
  std::uint64_t connects = 0;          ///< successful attempts
  std::uint64_t disconnects = 0;       ///< ended connections
  std::uint64_t silences = 0;          ///< of these, after read_time_out
  std::uint64_t received = 0;          ///< bytes
  std::uint64_t sent = 0;              ///< bytes handed to the kernel
  std::uint64_t requests_dropped = 0;  ///< without a connection or room in the queue
};

/// Why there is no connection.
struct TcpFault {
  enum class Kind : std::uint8_t { none, not_connected, ended, silent, dialogue_failed };
  Kind kind = Kind::none;
  int error = 0;    ///< as errno; 0: the device closed the connection
  Span silence{0};  ///< of a connection that ended by it

  explicit operator bool() const { return kind != Kind::none; }
};

struct TcpState {
  enum class Phase : std::uint8_t {
    stopped,
    connecting,
    waiting,  ///< until the next attempt
    connected
  };
  Phase phase = Phase::stopped;
  TcpFault fault{};  ///< none while connected; stays during the next attempt

  bool is_first_attempt() const { return phase == Phase::connecting && !fault; }
};

/// Handlers of a TcpSource; called from its io_context, disconnected() also from disconnect().
struct TcpHandlers {
  std::function<void(const Packet&)> receive;
  std::function<void(HostStamp)> connected;
  /// A connection reported by connected() ended; without TcpOptions::keep_up also: the attempt failed.
  std::function<void()> disconnected;
};

/// A TCP connection to a device, with the kernel's arrival stamps.
///
/// Never throws and never gives up: a connection that is refused, lost or silent becomes a state
/// with its fault and is retried, at the latest every `last_retry`. A peer that disappeared is detected by
/// `read_time_out` and, after 1.8 s, by an unanswered keep-alive of the kernel.
class TcpSource {
 public:
  TcpSource(boost::asio::io_context& io, TcpOptions options, TcpHandlers handlers);
  ~TcpSource();
  TcpSource(const TcpSource&) = delete;
  TcpSource& operator=(const TcpSource&) = delete;

  void start();
  /// No handler is called after this returns.
  void stop();
  /// Sends or queues bytes. False: not connected, or no room.
  bool send(ByteView bytes);
  /// Ends the connection. `again`: opens a new one after the usual delay; otherwise the source stops.
  void disconnect(bool again);
  /// Call after interfaces or addresses have changed: retries at once.
  void interfaces_changed();

  const TcpState& state() const;
  const TcpStats& stats() const;

 private:
  class Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace lidard
