// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "core/base/expected.h"
#include "drivers/file_descriptor.h"
#include "drivers/net/udp_source.h"

namespace lidard {

/// What a socket lets through and holds.
struct UdpLimits {
  bool filtered = false;  ///< the kernel drops what other senders send
  std::size_t buffer_asked = 0, buffer_got = 0;
};

/// A bound socket with stamps, drop counter, sender filter and receive buffer in place.
struct UdpSocket {
  FileDescriptor fd;
  std::uint16_t port = 0;
  UdpLimits limits;
};

Expected<UdpSocket> open_udp_socket(const UdpOptions& options);

/// Joins the group (again); 0, or the error as errno has it. Joining twice does no harm and heals a
/// membership that died with its interface. ENOBUFS: the socket has as many memberships, dead ones included,
/// as it may.
int join_group(int fd, const MulticastGroup& group);
/// What such an error means, with the remedy.
std::string why_not_joined(const MulticastGroup& group, int error);

/// Ends a membership; nothing happens where there is none.
void leave_group(int fd, const MulticastGroup& group);

/// Puts the sender filter and the receive buffer of `options` in place, also of a socket that receives.
UdpLimits limit_socket(int fd, const UdpOptions& options);

/// True if more than half of the receive buffer is occupied.
bool receive_buffer_is_filling(int fd);

/// The sentence for a buffer smaller than asked for; empty if it is large enough.
std::string buffer_warning(const UdpLimits& limits, const UdpOptions& options);

/// One receiving system call for up to 32 datagrams; its memory is allocated once.
class DatagramBatch {
 public:
  static constexpr std::size_t capacity = 32;
  struct Datagram {
    ByteView payload;
    std::optional<Stamp> kernel_stamp;
    Endpoint from;
    IpAddress to;
    bool truncated = false;
    std::uint32_t drops = 0;  ///< of the socket since it was opened
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
