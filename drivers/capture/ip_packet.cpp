// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/capture/ip_packet.h"

#include <algorithm>

namespace lidard {
namespace {

void set_bytes(ByteView rest, std::size_t declared, IpPacket& out) {
  out.captured = rest;
  out.declared = declared;
  out.transport = rest.sub(0, std::min(declared, rest.size()));
  out.shorter_than_declared = declared > rest.size();
}

/// RFC 791.
HeaderResult parse_v4(ByteView bytes, IpPacket& out) {
  if (!bytes.has(0, 20)) return HeaderResult::cut;
  const std::size_t header = (bytes.u8(0) & 0x0fU) * 4U;
  if (bytes.u8(0) >> 4U != 4 || header < 20) return HeaderResult::malformed;
  if (!bytes.has(0, header)) return HeaderResult::cut;
  std::copy_n(bytes.begin() + 12, 4, out.from.bytes.begin());
  std::copy_n(bytes.begin() + 16, 4, out.to.bytes.begin());
  out.protocol = bytes.u8(9);
  const std::uint32_t flags_and_offset = bytes.be16(6);
  out.fragment.more = (flags_and_offset & 0x2000U) != 0;
  out.fragment.offset = (flags_and_offset & 0x1fffU) * 8U;
  out.fragment.is_fragment = out.fragment.more || out.fragment.offset != 0;
  out.fragment.id = bytes.be16(4);
  const ByteView rest = bytes.from(header);
  std::size_t total = bytes.be16(2);
  // Hosts record what they leave to the network card to cut into packets (TCP segmentation offload) without
  // a length.
  if (total == 0 && out.protocol == static_cast<std::uint8_t>(IpProtocol::tcp)) total = header + rest.size();
  set_bytes(rest, total > header ? total - header : 0, out);
  return HeaderResult::ok;
}

// iana.org/assignments/ipv6-parameters, "IPv6 Extension Header Types".
constexpr std::uint8_t hop_by_hop = 0, routing = 43, fragment_header = 44, authentication = 51,
                       destination_options = 60, mobility = 135, host_identity = 139, shim6 = 140;

/// Length of an extension header in bytes, from its second byte; 0 if `type` is none (or no way leads past
/// it).
std::size_t extension_length(std::uint8_t type, std::uint8_t length) {
  switch (type) {
    case hop_by_hop:
    case routing:
    case destination_options:
    case mobility:
    case host_identity:
    case shim6:
      return (length + 1U) * 8U;  // RFC 8200 section 4
    case authentication:
      return (length + 2U) * 4U;  // RFC 4302 section 2.2
    default:
      return 0;
  }
}

/// RFC 8200 section 4.5. Leaves `rest` behind the header.
HeaderResult read_fragment_header(ByteView& rest, IpPacket& out) {
  if (!rest.has(0, 8)) return HeaderResult::cut;
  const std::uint32_t offset_and_more = rest.be16(2);
  out.fragment.offset = offset_and_more & 0xfff8U;
  out.fragment.more = (offset_and_more & 1U) != 0;
  out.fragment.is_fragment = out.fragment.more || out.fragment.offset != 0;
  out.fragment.id = rest.be32(4);
  out.protocol = rest.u8(0);
  rest = rest.from(8);
  return HeaderResult::ok;
}

/// Steps over extension headers, stops at the transport or inside a fragment.
HeaderResult walk_extensions(ByteView& rest, IpPacket& out) {
  while (!out.fragment.is_fragment) {
    if (out.protocol == fragment_header) {
      const HeaderResult result = read_fragment_header(rest, out);
      if (result != HeaderResult::ok) return result;
      continue;
    }
    const bool can_be_read = rest.has(0, 2);
    const std::size_t length = extension_length(out.protocol, can_be_read ? rest.u8(1) : 0);
    if (length == 0) return HeaderResult::ok;
    if (!can_be_read || !rest.has(0, length)) return HeaderResult::cut;
    out.protocol = rest.u8(0);
    rest = rest.from(length);
  }
  return HeaderResult::ok;
}

/// RFC 8200.
HeaderResult parse_v6(ByteView bytes, IpPacket& out) {
  if (!bytes.has(0, 40)) return HeaderResult::cut;
  if (bytes.u8(0) >> 4U != 6) return HeaderResult::malformed;
  out.from.v6 = out.to.v6 = true;
  std::copy_n(bytes.begin() + 8, 16, out.from.bytes.begin());
  std::copy_n(bytes.begin() + 24, 16, out.to.bytes.begin());
  out.protocol = bytes.u8(6);
  ByteView rest = bytes.from(40);
  const HeaderResult result = walk_extensions(rest, out);
  const std::size_t extensions = bytes.size() - 40 - rest.size();
  const std::size_t declared = bytes.be16(4);
  set_bytes(rest, declared > extensions ? declared - extensions : 0, out);
  return result;
}

}  // namespace

HeaderResult parse_ip(ByteView bytes, bool v6, IpPacket& out) {
  out = IpPacket();
  return v6 ? parse_v6(bytes, out) : parse_v4(bytes, out);
}

HeaderResult skip_reassembled_extensions(IpPacket& packet) {
  ByteView rest = packet.transport;
  packet.fragment = IpFragment();
  const HeaderResult result = packet.from.v6 ? walk_extensions(rest, packet) : HeaderResult::ok;
  if (packet.fragment.is_fragment) return HeaderResult::malformed;  // a fragment inside a reassembled packet
  packet.transport = packet.captured = rest;
  packet.declared = rest.size();
  packet.shorter_than_declared = false;
  return result;
}

/// RFC 768.
HeaderResult parse_udp(ByteView bytes, UdpDatagram& out) {
  if (!bytes.has(0, 8)) return HeaderResult::cut;
  const std::size_t length = bytes.be16(4);
  if (length < 8) return HeaderResult::malformed;
  if (!bytes.has(0, length)) return HeaderResult::cut;
  out.from_port = bytes.be16(0);
  out.to_port = bytes.be16(2);
  out.payload = bytes.sub(8, length - 8);
  return HeaderResult::ok;
}

/// RFC 9293 section 3.1.
HeaderResult parse_tcp(const IpPacket& packet, TcpSegment& out) {
  const ByteView bytes = packet.transport;
  if (!bytes.has(0, 20)) return HeaderResult::cut;
  const std::size_t header = (bytes.u8(12) >> 4U) * 4U;
  if (header < 20 || header > packet.declared) return HeaderResult::malformed;
  if (!bytes.has(0, header)) return HeaderResult::cut;
  out.from_port = bytes.be16(0);
  out.to_port = bytes.be16(2);
  out.sequence = bytes.be32(4);
  out.acknowledgement = bytes.be32(8);
  const std::uint8_t flags = bytes.u8(13);
  out.fin = (flags & 0x01U) != 0;
  out.syn = (flags & 0x02U) != 0;
  out.rst = (flags & 0x04U) != 0;
  out.ack = (flags & 0x10U) != 0;
  out.payload = bytes.from(header);
  out.length = static_cast<std::uint32_t>(packet.declared - header);
  return HeaderResult::ok;
}

}  // namespace lidard
