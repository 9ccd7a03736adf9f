// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace lidard::test {

/// Runs `body` in a process of its own, since roscpp allows one node per process; its failed expectations
/// fail the calling test. The calling process must have no threads.
void in_own_process(const std::function<void()>& body);

/// A TCP port of the loopback that is free.
std::uint16_t free_port();

/// A child process that ends with its owner.
class Child {
 public:
  Child() = default;
  /// Starts a program.
  explicit Child(const std::vector<std::string>& command);
  /// Calls a function in a forked process.
  explicit Child(const std::function<void()>& body);
  ~Child() { kill(); }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  Child(Child&& other) noexcept : pid_(other.pid_) { other.pid_ = 0; }
  Child& operator=(Child&& other) noexcept;

  /// Stops, continues or kills it; the last waits for its end.
  void pause();
  void resume();
  void kill();
  pid_t pid() const { return pid_; }

 private:
  pid_t pid_ = 0;
};

/// A real rosmaster on a port of its own. The constructor only chooses the port and sets ROS_MASTER_URI,
/// ROS_IP and ROS_LOG_DIR of this process; the master starts with start().
class RosMaster {
 public:
  RosMaster();
  ~RosMaster();
  /// Starts it and waits until it answers.
  void start();
  void kill() { process_.kill(); }
  void pause() { process_.pause(); }
  void resume() { process_.resume(); }
  std::uint16_t port() const { return port_; }
  std::string uri() const { return "http://127.0.0.1:" + std::to_string(port_); }

 private:
  std::uint16_t port_;
  std::string logs_;
  Child process_;
};

/// Output of a shell command that ends within `seconds`; "" if it does not.
std::string output_of(const std::string& command, int seconds);

}  // namespace lidard::test
