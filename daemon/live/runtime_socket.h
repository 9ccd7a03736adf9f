// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/steady_timer.hpp>
#include <functional>
#include <map>
#include <string>

namespace lidard {

/// Where a daemon is asked how it is: $LIDARD_SOCKET, or `control` in $RUNTIME_DIRECTORY (systemd), else in
/// $XDG_RUNTIME_DIR/lidard, else in /run/lidard.
std::string runtime_socket_path();
/// Where to ask the daemon that runs: there, or, where no such daemon is, the one of the service.
std::string running_socket_path();

/// Answers questions of programs on the same computer, over a socket in the file system: one line with a word
/// comes in, a text goes out, and the connection ends. Whoever may write to the socket's file may ask.
class RuntimeSocket {
 public:
  using Reply = std::function<void(std::string text)>;
  /// What is done for each word. Called from within `io`, as `reply` has to be, at once or later.
  using Answers = std::map<std::string, std::function<void(const Reply& reply)>>;

  RuntimeSocket(boost::asio::io_context& io, Answers answers);
  ~RuntimeSocket();  // NOLINT(bugprone-exception-escape): see there

  /// Empty, or why nobody can ask: another daemon answers there, the folder cannot be written to.
  std::string start(const std::string& path);
  void stop();

 private:
  class Talk;
  void accept();

  boost::asio::local::stream_protocol::acceptor acceptor_;
  boost::asio::steady_timer pause_;
  const Answers answers_;
  std::string path_;  // while it is ours
};

/// Asks the daemon at `path`; throws std::runtime_error with the remedy if there is none.
std::string ask_daemon(const std::string& path, const std::string& word);

}  // namespace lidard
