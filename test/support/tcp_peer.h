// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

namespace lidard::test {

/// The device's side of a connection, over loopback: plain sockets, no threads.
class TcpPeer {
 public:
  /// Listens at 127.0.0.1; port 0: any. `backlog` as in listen(2).
  explicit TcpPeer(std::uint16_t port = 0, int backlog = 16);
  ~TcpPeer();
  TcpPeer(const TcpPeer&) = delete;
  TcpPeer& operator=(const TcpPeer&) = delete;

  std::uint16_t port() const { return port_; }
  /// Takes a client that waits, and closes the one before. False: none waits.
  bool accept();
  /// Sends to the client of the last accept(); false on an error.
  bool send(const std::string& bytes);
  /// What the client has sent and the test has not read yet.
  std::string read();
  void close_client();
  /// Ends the client's connection with a reset.
  void reset_client();
  /// Forgets the client's connection without a word to it, as a power cut does. False: needs privileges.
  bool vanish();
  void stop_listening();
  /// Listens again on the same port.
  void listen_again(int backlog = 16);

 private:
  int listener_ = -1;
  int client_ = -1;
  std::uint16_t port_ = 0;
};

}  // namespace lidard::test
