// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "drivers/driver.h"

namespace boost::asio {
class io_context;
}

namespace lidard {

struct TcpOptions {
  Endpoint device;
  Span connect_time_out = std::chrono::milliseconds(800);
  /// No byte for so long: the connection is opened anew. 0: silence is no fault.
  Span read_time_out{0};
  Span first_retry =
      std::chrono::milliseconds(100);  ///< from the begin of one attempt to the next, then doubled
  Span last_retry = std::chrono::milliseconds(1000);
  /// False: one attempt for each start(), and no other connection when that one ended.
  bool keep_up = true;
  std::size_t send_limit = std::size_t{64} * 1024;  ///< bytes that may wait for a device that does not read
};

struct TcpStats {
  std::uint64_t attempts = 0;          ///< to connect
  std::uint64_t connects = 0;          ///< that succeeded
  std::uint64_t disconnects = 0;       ///< connections that ended, whoever ended them
  std::uint64_t silences = 0;          ///< of these, for want of bytes
  std::uint64_t received = 0;          ///< bytes
  std::uint64_t sent = 0;              ///< bytes handed to the kernel
  std::uint64_t requests_dropped = 0;  ///< for want of a connection, or of room
};

struct TcpState {
  enum class Phase : std::uint8_t {
    stopped,
    connecting,
    waiting,  ///< for the next attempt
    connected
  };
  Phase phase = Phase::stopped;
  std::string message;  ///< what is wrong and the remedy; empty while connected
};

/// What a TcpSource tells; called from within its io_context, and disconnected() also from disconnect().
struct TcpHandlers {
  std::function<void(const Packet&)> receive;
  std::function<void(Stamp)> connected;
  /// Every connection of which connected() told ended; without TcpOptions::keep_up also: the attempt failed.
  std::function<void()> disconnected;
};

/// A connection to a device that waits for clients, with the kernel's time of arrival of what it sends.
///
/// Never throws and never gives up: a connection that is refused, lost or silent becomes a state with a
/// message and is tried again, first soon, then every `last_retry`. A peer that vanished without a word is
/// noticed by its silence (`read_time_out`), and after 1.8 s by a keep-alive of the kernel without an answer.
class TcpSource {
 public:
  TcpSource(boost::asio::io_context& io, TcpOptions options, TcpHandlers handlers);
  ~TcpSource();
  TcpSource(const TcpSource&) = delete;
  TcpSource& operator=(const TcpSource&) = delete;

  void start();
  /// No handler is called any more once this returned, disconnected() neither.
  void stop();
  /// Sends at once, or when the device reads again. False: not connected, or no room.
  bool send(ByteView bytes);
  /// Ends the connection; `again`: and opens another one after the usual delay, else the source is stopped.
  void disconnect(bool again, const std::string& why);
  /// Changes TcpOptions::read_time_out.
  void set_read_time_out(Span time_out);
  /// Interfaces or addresses have changed: tries at once to connect, instead of when the pause is over.
  void interfaces_changed();

  const TcpState& state() const;
  const TcpStats& stats() const;

 private:
  class Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace lidard
