// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <functional>

namespace lidard {

/// Reports changes of this host's interfaces, addresses and routes as soon as the kernel does.
class InterfaceWatch {
 public:
  /// `changed` is called from `io`, once for several changes at a time.
  InterfaceWatch(boost::asio::io_context& io, std::function<void()> changed);

  /// 0, or the error (as errno) if the kernel does not report changes; then only timers find them.
  int start();
  void stop();

 private:
  void wait();
  void report();

  boost::asio::posix::stream_descriptor descriptor_;
  boost::asio::steady_timer timer_;
  std::function<void()> changed_;
};

}  // namespace lidard
