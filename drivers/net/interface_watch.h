// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <functional>
#include <string>

namespace lidard {

/// Tells that interfaces, addresses or routes of this host came, went or changed, as soon as the kernel says
/// so.
class InterfaceWatch {
 public:
  /// `changed` is called from within `io`, once for all that changed at a time.
  InterfaceWatch(boost::asio::io_context& io, std::function<void()> changed);

  /// Empty, or why the kernel tells nothing: then timers alone find what changed.
  std::string start();
  void stop();

 private:
  void wait();
  void tell();

  boost::asio::posix::stream_descriptor descriptor_;
  boost::asio::steady_timer timer_;
  std::function<void()> changed_;
};

}  // namespace lidard
