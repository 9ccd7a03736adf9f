// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/capture/link_layer.h"

namespace lidard {
namespace {

// tcpdump.org/linktypes.html; 12 and 14 are DLT_RAW of Linux and of OpenBSD, which stray into files.
constexpr std::uint32_t link_null = 0, link_ethernet = 1, link_raw_linux = 12, link_raw_openbsd = 14,
                        link_raw = 101, link_loop = 108, link_sll = 113, link_ipv4 = 228, link_ipv6 = 229,
                        link_sll2 = 276;

// IEEE 802 numbers (iana.org/assignments/ieee-802-numbers); 0x9100 and 0x9200 came before IEEE 802.1ad.
constexpr std::uint16_t ether_ipv4 = 0x0800, ether_ipv6 = 0x86dd;

constexpr bool is_vlan_tag(std::uint16_t type) {
  return type == 0x8100 || type == 0x88a8 || type == 0x9100 || type == 0x9200;
}

HeaderResult found(ByteView packet, bool v6, LinkPayload& out) {
  out = {packet, v6};
  return HeaderResult::ok;
}

HeaderResult after_type(ByteView frame, std::uint16_t type, std::size_t offset, LinkPayload& out) {
  while (is_vlan_tag(type)) {
    if (!frame.has(offset, 4)) return HeaderResult::cut;
    type = frame.be16(offset + 2);
    offset += 4;
  }
  if (type != ether_ipv4 && type != ether_ipv6) return HeaderResult::not_ip;
  return found(frame.from(offset), type == ether_ipv6, out);
}

/// A header of `length` bytes with the ethertype of its payload at `type_offset`.
HeaderResult typed(ByteView frame, std::size_t type_offset, std::size_t length, LinkPayload& out) {
  if (!frame.has(0, length)) return HeaderResult::cut;
  return after_type(frame, frame.be16(type_offset), length, out);
}

HeaderResult raw(ByteView frame, LinkPayload& out) {
  if (frame.empty()) return HeaderResult::cut;
  const unsigned version = frame.u8(0) >> 4U;
  if (version != 4 && version != 6) return HeaderResult::not_ip;
  return found(frame, version == 6, out);
}

/// The family is in the byte order of the recording host (null) or of the network (loop): all values are
/// small.
HeaderResult null_or_loop(ByteView frame, LinkPayload& out) {
  if (!frame.has(0, 4)) return HeaderResult::cut;
  const std::uint32_t family = frame.le32(0) > 0xffffU ? frame.be32(0) : frame.le32(0);
  // AF_INET is 2 everywhere; AF_INET6 is 10 on Linux, 24, 28 and 30 on the BSDs and macOS
  // (tcpdump.org/linktypes.html).
  const bool v6 = family == 10 || family == 24 || family == 28 || family == 30;
  if (family != 2 && !v6) return HeaderResult::not_ip;
  return found(frame.from(4), v6, out);
}

}  // namespace

HeaderResult find_ip(std::uint32_t link_type, ByteView frame, LinkPayload& out) {
  switch (link_type) {
    case link_ethernet:
      return typed(frame, 12, 14, out);
    case link_sll:
      return typed(frame, 14, 16, out);
    case link_sll2:
      return typed(frame, 0, 20, out);
    case link_raw:
    case link_raw_linux:
    case link_raw_openbsd:
      return raw(frame, out);
    case link_null:
    case link_loop:
      return null_or_loop(frame, out);
    case link_ipv4:
    case link_ipv6:
      return found(frame, link_type == link_ipv6, out);
    default:
      return HeaderResult::unsupported;
  }
}

}  // namespace lidard
