// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/time.h"
#include "drivers/address.h"

namespace lidard {

/// Result of parsing a header.
enum class HeaderResult : std::uint8_t {
  ok,
  not_ip,       ///< another protocol
  unsupported,  ///< a link-layer type we do not read
  cut,          ///< the bytes end before the header does
  malformed     ///< the header contradicts itself
};

/// The network-layer packet inside a link-layer frame.
struct LinkPayload {
  ByteView bytes;  ///< from the IP header to the end of the frame, padding included
  bool v6 = false;
};

/// Finds the IP packet in a frame of the given link-layer type, a LINKTYPE_ or DLT_ number
/// (tcpdump.org/linktypes.html): Ethernet with any number of VLAN tags, Linux cooked v1 and v2, raw IP, null,
/// loop.
HeaderResult find_ip(std::uint32_t link_type, ByteView frame, LinkPayload& out);

/// IP protocol numbers (iana.org/assignments/protocol-numbers).
enum class IpProtocol : std::uint8_t { tcp = 6, udp = 17 };

/// Place of a fragment; a complete packet has `is_fragment` false.
struct IpFragment {
  bool is_fragment = false;
  bool more = false;         ///< another one follows
  std::uint32_t offset = 0;  ///< bytes
  std::uint32_t id = 0;
};

/// An IP packet: its addresses, and the bytes of the transport protocol inside.
struct IpPacket {
  IpAddress from;
  IpAddress to;
  std::uint8_t protocol = 0;  ///< of the transport; in a fragment: of what stands at its beginning
  /// The bytes that the IP length covers, as far as they were captured.
  ByteView transport;
  /// All bytes behind the IP headers, padding included: for UDP, whose own length is more reliable (a known
  /// capture has IP lengths of 1234 on packets of 540 bytes).
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

/// Result of adding a fragment.
enum class DefragResult : std::uint8_t {
  waiting,   ///< kept (or dropped: see the counter); more must come
  complete,  ///< the packet is complete
  malformed  ///< not a possible fragment; not kept
};

/// Puts IP fragments together again, in whatever order they come.
///
/// Memory is bounded: at most `max_packets` unfinished packets of at most 65 535 bytes; the oldest gives way.
/// An unfinished packet is given up after `time_out` of capture time, as Linux does (net.ipv4.ipfrag_time). A
/// packet whose fragments overlap with different content is dropped (RFC 5722, and Linux for IPv4).
class IpDefragmenter {
 public:
  static constexpr std::size_t max_packets = 64;
  static constexpr Span time_out = std::chrono::seconds(30);

  /// Adds a fragment. When it completes its packet, `packet` becomes the complete one, whose bytes stay valid
  /// until the next call.
  DefragResult add(IpPacket& packet, Stamp now);
  /// No more input: drops unfinished packets.
  void flush();

  /// Fragments that came twice, contradicted others, or belong to packets given up.
  std::uint64_t dropped() const { return dropped_; }
  /// Packets begun and not finished yet.
  std::size_t pending() const;
  /// Bytes held for them.
  std::size_t memory() const;

 private:
  struct Range {
    std::uint32_t begin, end;
  };
  struct Slot {
    bool used = false;
    IpAddress from, to;
    std::uint8_t protocol = 0;
    std::uint32_t id = 0;
    Stamp since;
    std::uint64_t fragments = 0;
    std::uint32_t total = 0;  // 0: the last fragment has not come yet
    std::vector<std::uint8_t> bytes;
    std::vector<Range> ranges;  // received, sorted, disjoint, never touching

    bool matches(const IpPacket& packet) const;
    bool whole() const;
    bool has_all(Range range) const;
    bool contradicts(const IpPacket& fragment, Range range) const;
    void store(ByteView content, Range range);
    void insert(Range range);
  };

  void expire(Stamp now);
  void give_up(Slot& slot);
  Slot& find_or_begin(const IpPacket& packet, Stamp now);

  std::vector<Slot> slots_;
  std::uint64_t dropped_ = 0;
};

}  // namespace lidard
