// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/driver.h"
#include "drivers/file_descriptor.h"
#include "drivers/net/host_network.h"

namespace lidard {

/// A multicast group to listen to.
struct MulticastGroup {
  IpAddress group;
  std::string interface;  ///< name or IPv4 address of the host's interface; empty: the kernel chooses

  friend bool operator==(const MulticastGroup& a, const MulticastGroup& b) {
    return a.group == b.group && a.interface == b.interface;
  }
};

struct UdpOptions {
  std::uint16_t port = 0;                         ///< local; 0 lets the kernel choose
  IpAddress address = IpAddress::v4(0, 0, 0, 0);  ///< local; 0.0.0.0 survives changes of the interfaces
  std::vector<IpAddress> senders;                 ///< IPv4; empty: any sender
  std::vector<MulticastGroup> groups;
  double packets_per_s = 1000;  ///< of all sensors on this port
  /// Half a second, plus the time to start reading again.
  Span tolerated_stall = std::chrono::milliseconds(600);
  std::size_t receive_buffer =
      0;  ///< bytes, as in SO_RCVBUF; 0: from rate and stall, but not below the system's default
  std::size_t max_datagram =
      2048;                 ///< bytes of payload; longer datagrams are counted as truncated and dropped
  bool share_port = false;  ///< let other programs receive the same broadcasts and multicasts
};

/// Why a port does not receive, or not all.
struct UdpFault {
  int error = 0;           ///< as errno; 0: no fault
  MulticastGroup group{};  ///< that was not joined; else the port could not be opened or read
  PortHolder holder{};     ///< of a port in use

  explicit operator bool() const { return error != 0; }
};

/// The limits in force of a socket.
struct UdpLimits {
  bool filtered = false;  ///< the kernel drops datagrams of other senders
  std::size_t buffer_asked = 0, buffer_got = 0;
  Span buffer_lasts{0};  ///< until it is full, while nobody reads
};

/// A bound socket with stamps, drop counter, sender filter and receive buffer in place.
struct UdpSocket {
  FileDescriptor fd;
  std::uint16_t port = 0;
  UdpLimits limits;
  UdpFault fault;  ///< none: it is open
};

UdpSocket open_udp_socket(const UdpOptions& options);

/// Joins the group (again); returns 0 or errno. Repeated calls are harmless and restore a membership that was
/// lost with its interface. ENOBUFS: the limit of memberships, lost ones included, is reached.
int join_group(int fd, const MulticastGroup& group);

/// Ends a membership, if there is one.
void leave_group(int fd, const MulticastGroup& group);

/// Applies the sender filter and the receive buffer of `options`, also to a socket in use.
UdpLimits limit_socket(int fd, const UdpOptions& options);

/// True if more than half of the receive buffer is occupied.
bool receive_buffer_is_filling(int fd);

/// One receiving system call for up to 32 datagrams; its memory is allocated once.
class DatagramBatch {
 public:
  static constexpr std::size_t capacity = 32;
  struct Datagram {
    ByteView payload;
    std::optional<HostStamp> kernel_stamp;
    Endpoint from;
    IpAddress to;
    bool truncated = false;
    std::uint32_t drops = 0;  ///< dropped by the socket since it was opened
  };

  explicit DatagramBatch(std::size_t max_datagram);
  ~DatagramBatch();
  /// Number of datagrams; -1 with errno set on an error.
  int receive(int fd);
  Datagram operator[](std::size_t i) const;

 private:
  struct Storage;
  std::size_t max_datagram_;
  std::unique_ptr<Storage> storage_;
};

}  // namespace lidard
