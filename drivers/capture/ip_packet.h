// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "core/base/bytes.h"
#include "drivers/address.h"
#include "drivers/capture/link_layer.h"

namespace lidard {

/// IP protocol numbers (iana.org/assignments/protocol-numbers).
enum class IpProtocol : std::uint8_t { tcp = 6, udp = 17 };

/// Where a fragment belongs; the whole packet has `is_fragment` false.
struct IpFragment {
  bool is_fragment = false;
  bool more = false;         ///< another one follows
  std::uint32_t offset = 0;  ///< bytes
  std::uint32_t id = 0;
};

/// An IP packet: who to whom, and the bytes of the transport protocol inside.
struct IpPacket {
  IpAddress from;
  IpAddress to;
  std::uint8_t protocol = 0;  ///< of the transport; in a fragment: of what stands at its beginning
  /// The bytes that the IP length covers, as far as they were captured.
  ByteView transport;
  /// All bytes behind the IP headers, padding included: for UDP, whose own length is the better witness
  /// (a known capture has IP lengths of 1234 on packets of 540 bytes).
  ByteView captured;
  std::size_t declared = 0;            ///< bytes of the transport that the IP length promises
  bool shorter_than_declared = false;  ///< `transport` holds less than that
  IpFragment fragment;
};

/// Reads the IPv4 or IPv6 headers at the beginning of `bytes`.
HeaderResult parse_ip(ByteView bytes, bool v6, IpPacket& out);

/// Steps over the IPv6 extension headers that a packet put together from fragments may begin with.
HeaderResult skip_reassembled_extensions(IpPacket& packet);

/// A UDP datagram.
struct UdpDatagram {
  std::uint16_t from_port = 0;
  std::uint16_t to_port = 0;
  ByteView payload;
};

/// Reads the UDP header; `bytes` may go on behind the datagram. `cut`: fewer bytes than the UDP length
/// promises. The checksum is not verified: hosts record what they send before the network card fills it in.
HeaderResult parse_udp(ByteView bytes, UdpDatagram& out);

/// A TCP segment.
struct TcpSegment {
  std::uint16_t from_port = 0;
  std::uint16_t to_port = 0;
  std::uint32_t sequence = 0;
  std::uint32_t acknowledgement = 0;
  bool syn = false, ack = false, fin = false, rst = false;
  ByteView payload;          ///< as far as it was captured
  std::uint32_t length = 0;  ///< of the payload as it was sent
};

/// Reads the TCP header of a packet. The checksum is not verified, as for UDP.
HeaderResult parse_tcp(const IpPacket& packet, TcpSegment& out);

}  // namespace lidard
