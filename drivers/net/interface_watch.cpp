// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/net/interface_watch.h"

#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>

#include "drivers/file_descriptor.h"

namespace lidard {
namespace {

/// One `ip link add` makes several messages; a program that changes routes all the time makes thousands.
constexpr auto collecting = std::chrono::milliseconds(50);

/// Discards the messages; the handler reads the new state.
void drain(int fd) {
  std::array<char, 8192> ignored;
  // ENOBUFS (overrun of the buffer) does not end the messages.
  while (recv(fd, ignored.data(), ignored.size(), MSG_DONTWAIT) > 0 || errno == ENOBUFS || errno == EINTR)
    errno = 0;
}

}  // namespace

InterfaceWatch::InterfaceWatch(boost::asio::io_context& io, std::function<void()> changed)
    : descriptor_(io), timer_(io), changed_(std::move(changed)) {}

int InterfaceWatch::start() {
  FileDescriptor fd(socket(AF_NETLINK, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, NETLINK_ROUTE));
  sockaddr_nl local{};
  local.nl_family = AF_NETLINK;
  local.nl_groups = RTMGRP_LINK | RTMGRP_IPV4_IFADDR | RTMGRP_IPV4_ROUTE;
  boost::system::error_code error;
  if (fd.get() < 0 || bind(fd.get(), reinterpret_cast<const sockaddr*>(&local), sizeof local) != 0)
    error.assign(errno, boost::system::system_category());
  else
    descriptor_.assign(fd.get(), error);
  if (error) return error.value();
  fd.release();
  wait();
  return 0;
}

void InterfaceWatch::stop() {
  boost::system::error_code ignored;
  timer_.cancel(ignored);
  descriptor_.close(ignored);
}

void InterfaceWatch::wait() {
  descriptor_.async_wait(boost::asio::posix::stream_descriptor::wait_read, [this](const auto& error) {
    if (error) return;
    timer_.expires_after(collecting);
    timer_.async_wait([this](const auto& cancelled) {
      if (!cancelled) report();
    });
  });
}

void InterfaceWatch::report() {
  drain(descriptor_.native_handle());
  wait();
  changed_();
}

}  // namespace lidard
