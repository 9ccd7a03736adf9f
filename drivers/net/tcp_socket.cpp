// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/net/tcp_socket.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>

#include "drivers/net/wall_clock.h"

namespace lidard {
namespace {

constexpr int keep_alive_after_s = 1;
constexpr int keep_alive_every_s = 1;
constexpr int keep_alive_tries = 2;
/// Bytes of ours without an answer for so long: the peer is gone.
constexpr unsigned int user_time_out_ms = 3000;

template <class T>
void set(int fd, int level, int option, T value) {
  // All of them are refinements: where the system has no such option the connection works without.
  static_cast<void>(::setsockopt(fd, level, option, &value, sizeof value));
}

}  // namespace

void prepare_tcp_socket(int fd) {
  set(fd, IPPROTO_TCP, TCP_NODELAY, 1);
  set(fd, SOL_SOCKET, SO_KEEPALIVE, 1);
  set(fd, IPPROTO_TCP, TCP_KEEPIDLE, keep_alive_after_s);
  set(fd, IPPROTO_TCP, TCP_KEEPINTVL, keep_alive_every_s);
  set(fd, IPPROTO_TCP, TCP_KEEPCNT, keep_alive_tries);
  set(fd, IPPROTO_TCP, TCP_USER_TIMEOUT, user_time_out_ms);
  set(fd, SOL_SOCKET, SO_TIMESTAMPNS, 1);
}

ssize_t receive_bytes(int fd, std::uint8_t* to, std::size_t room, Stamp& stamp) {
  struct alignas(cmsghdr) Control {
    std::array<char, CMSG_SPACE(sizeof(timespec))> bytes;
  } control{};
  iovec vector{to, room};
  msghdr header{};
  header.msg_iov = &vector;
  header.msg_iovlen = 1;
  header.msg_control = control.bytes.data();
  header.msg_controllen = control.bytes.size();
  const ssize_t got = ::recvmsg(fd, &header, MSG_DONTWAIT);
  if (got <= 0) return got;
  for (cmsghdr* c = CMSG_FIRSTHDR(&header); c != nullptr; c = CMSG_NXTHDR(&header, c)) {
    if (c->cmsg_level != SOL_SOCKET || c->cmsg_type != SCM_TIMESTAMPNS) continue;
    timespec time{};
    std::memcpy(&time, CMSG_DATA(c), sizeof time);
    stamp = Stamp{time.tv_sec * 1'000'000'000 + time.tv_nsec};
    if (stamp.ns != 0) return got;
  }
  stamp = wall_clock();
  return got;
}

ssize_t send_bytes(int fd, ByteView bytes) {
  return ::send(fd, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
}

std::string why_not_connected(const Endpoint& device, int error) {
  const std::string name = device.to_string();
  switch (error) {
    case ECONNREFUSED:
      return name + " refuses the connection; is this the device's port, and does another program use the " +
             "device already? it is tried again";
    case ETIMEDOUT:
      return name + " does not answer; check the device's power, cable and address, it is tried again";
    case EHOSTUNREACH:
    case ENETUNREACH:
    case ENETDOWN:
    case EHOSTDOWN:
      return name + " cannot be reached (" + std::strerror(error) +
             "); check cable and this host's network address, it is tried again";
    case EMFILE:
    case ENFILE:
      return std::string("no connection to ") + name + ": " + std::strerror(error) +
             "; raise the limit of open files (LimitNOFILE of the unit), it is tried again";
    default:
      return "no connection to " + name + ": " + std::strerror(error) + "; it is tried again";
  }
}

std::string why_disconnected(const Endpoint& device, int error) {
  const std::string name = device.to_string();
  switch (error) {
    case 0:
      return name + " closed the connection; did it restart, or does another program use the device? " +
             "the connection is opened again";
    case ECONNRESET:
    case EPIPE:
      return name + " reset the connection; did it restart, or does another program use the device? " +
             "the connection is opened again";
    case ETIMEDOUT:
      return name + " does not answer any more; check its power and cable, it is tried again";
    default:
      return "the connection to " + name + " broke: " + std::strerror(error) + "; it is opened again";
  }
}

}  // namespace lidard
