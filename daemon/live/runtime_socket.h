// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/steady_timer.hpp>
#include <functional>
#include <map>
#include <string>

namespace lidard {

/// A daemon's folder for what lives as long as it runs: $RUNTIME_DIRECTORY (systemd), else
/// $XDG_RUNTIME_DIR/lidard, else /run/lidard.
std::string runtime_folder();
/// The path of a daemon's runtime socket: $LIDARD_SOCKET, or `control` in the runtime folder.
std::string runtime_socket_path();
/// The socket of the running daemon: the path above, or that of the service if no socket exists there.
std::string running_socket_path();

/// Answers requests of programs on the same computer over a Unix socket: a request is one line with one word,
/// the answer is a text, and the connection is closed. Every user with write access to the socket's file may
/// send requests.
class RuntimeSocket {
 public:
  using Reply = std::function<void(std::string text)>;
  /// A handler per word. The handler is called from `io` and calls `reply` from `io`, at once or later.
  using Answers = std::map<std::string, std::function<void(const Reply& reply)>>;

  RuntimeSocket(boost::asio::io_context& io, Answers answers);
  ~RuntimeSocket();  // NOLINT(bugprone-exception-escape): see the definition

  /// Empty, or why the socket cannot be opened: another daemon answers there, or the folder is not writable.
  std::string start(const std::string& path);
  void stop();

 private:
  class Talk;
  void accept();

  boost::asio::local::stream_protocol::acceptor acceptor_;
  boost::asio::steady_timer pause_;
  const Answers answers_;
  std::string path_;  // empty: not opened
};

/// Sends a request to the daemon at `path`; throws std::runtime_error with the remedy if there is none, or if
/// it does not answer within `limit`.
std::string ask_daemon(const std::string& path, const std::string& word,
                       std::chrono::milliseconds limit = std::chrono::seconds(15));

}  // namespace lidard
