// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/capture/ip_packet.h"

#include <algorithm>

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
  const std::size_t header = std::size_t{4} * (bytes.u8(0) & 0x0fU);
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

/// Length of an extension header in bytes, from its second byte; 0 if `type` is none (or cannot be skipped).
std::size_t extension_length(std::uint8_t type, std::uint8_t length) {
  switch (type) {
    case hop_by_hop:
    case routing:
    case destination_options:
    case mobility:
    case host_identity:
    case shim6:
      return std::size_t{8} * (length + 1U);  // RFC 8200 section 4
    case authentication:
      return std::size_t{4} * (length + 2U);  // RFC 4302 section 2.2
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

/// RFC 768: a source port of 0 means none; no socket has port 0 (RFC 6335 section 6).
HeaderResult parse_udp(ByteView bytes, UdpDatagram& out) {
  if (!bytes.has(0, 8)) return HeaderResult::cut;
  const std::size_t length = bytes.be16(4);
  if (length < 8) return HeaderResult::malformed;
  if (!bytes.has(0, length)) return HeaderResult::cut;
  out.from_port = bytes.be16(0);
  out.to_port = bytes.be16(2);
  if (out.to_port == 0) return HeaderResult::malformed;
  out.payload = bytes.sub(8, length - 8);
  return HeaderResult::ok;
}

/// RFC 9293 section 3.1.
HeaderResult parse_tcp(const IpPacket& packet, TcpSegment& out) {
  const ByteView bytes = packet.transport;
  if (!bytes.has(0, 20)) return HeaderResult::cut;
  const std::size_t header = std::size_t{4} * (bytes.u8(12) >> 4U);
  if (header < 20 || header > packet.declared) return HeaderResult::malformed;
  if (!bytes.has(0, header)) return HeaderResult::cut;
  out.from_port = bytes.be16(0);
  out.to_port = bytes.be16(2);
  if (out.from_port == 0 || out.to_port == 0) return HeaderResult::malformed;
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

namespace {
constexpr std::size_t max_packet_bytes = 65535;  // RFC 791 and RFC 8200: 16-bit lengths
}  // namespace

bool IpDefragmenter::Slot::matches(const IpPacket& packet) const {
  return used && id == packet.fragment.id && protocol == packet.protocol && from == packet.from &&
         to == packet.to;
}

bool IpDefragmenter::Slot::whole() const {
  return total != 0 && ranges.size() == 1 && ranges[0].begin == 0 && ranges[0].end == total;
}

bool IpDefragmenter::Slot::has_all(Range range) const {
  return std::any_of(ranges.begin(), ranges.end(),
                     [&](const Range& r) { return r.begin <= range.begin && range.end <= r.end; });
}

bool IpDefragmenter::Slot::contradicts(const IpPacket& fragment, Range range) const {
  if (total != 0 && (range.end > total || (!fragment.fragment.more && range.end != total))) return true;
  if (!fragment.fragment.more && !ranges.empty() && ranges.back().end > range.end) return true;
  return std::any_of(ranges.begin(), ranges.end(), [&](const Range& r) {
    const std::uint32_t begin = std::max(r.begin, range.begin);
    const std::uint32_t end = std::min(r.end, range.end);
    return begin < end && !std::equal(bytes.begin() + begin, bytes.begin() + end,
                                      fragment.transport.begin() + (begin - range.begin));
  });
}

void IpDefragmenter::Slot::store(ByteView content, Range range) {
  if (bytes.size() < range.end) bytes.resize(range.end);
  std::copy(content.begin(), content.end(), bytes.begin() + range.begin);
  insert(range);
}

void IpDefragmenter::Slot::insert(Range range) {
  const auto first =
      std::find_if(ranges.begin(), ranges.end(), [&](const Range& r) { return r.end >= range.begin; });
  auto last = first;
  for (; last != ranges.end() && last->begin <= range.end; ++last) {
    range.begin = std::min(range.begin, last->begin);
    range.end = std::max(range.end, last->end);
  }
  ranges.insert(ranges.erase(first, last), range);
}

void IpDefragmenter::give_up(Slot& slot) {
  dropped_ += slot.fragments;
  slot.used = false;
}

void IpDefragmenter::expire(Stamp now) {
  for (Slot& slot : slots_) {
    if (slot.used && now - slot.since > time_out) give_up(slot);
  }
}

IpDefragmenter::Slot& IpDefragmenter::find_or_begin(const IpPacket& packet, Stamp now) {
  const auto known =
      std::find_if(slots_.begin(), slots_.end(), [&](const Slot& s) { return s.matches(packet); });
  if (known != slots_.end()) return *known;
  auto slot = std::find_if(slots_.begin(), slots_.end(), [](const Slot& s) { return !s.used; });
  if (slot == slots_.end() && slots_.size() < max_packets) slot = slots_.emplace(slots_.end());
  if (slot == slots_.end()) {
    slot = std::min_element(slots_.begin(), slots_.end(),
                            [](const Slot& a, const Slot& b) { return a.since < b.since; });
    give_up(*slot);
  }
  slot->used = true;
  slot->from = packet.from;
  slot->to = packet.to;
  slot->protocol = packet.protocol;
  slot->id = packet.fragment.id;
  slot->since = now;
  slot->fragments = 0;
  slot->total = 0;
  slot->bytes.clear();
  slot->ranges.clear();
  return *slot;
}

DefragResult IpDefragmenter::add(IpPacket& packet, Stamp now) {
  const std::size_t length = packet.transport.size();
  const std::size_t end = packet.fragment.offset + length;
  const bool odd_middle = packet.fragment.more && length % 8 != 0;
  if (length == 0 || odd_middle || end > max_packet_bytes) return DefragResult::malformed;
  expire(now);
  Slot& slot = find_or_begin(packet, now);
  const Range range{packet.fragment.offset, static_cast<std::uint32_t>(end)};
  ++slot.fragments;
  if (slot.contradicts(packet, range)) {
    give_up(slot);
    return DefragResult::waiting;
  }
  if (!packet.fragment.more) slot.total = range.end;
  if (slot.has_all(range)) {
    --slot.fragments;
    ++dropped_;
  } else {
    slot.store(packet.transport, range);
  }
  if (!slot.whole()) return DefragResult::waiting;
  slot.used = false;
  packet.transport = packet.captured = ByteView(slot.bytes.data(), slot.total);
  return DefragResult::complete;
}

void IpDefragmenter::flush() {
  for (Slot& slot : slots_) {
    if (slot.used) give_up(slot);
  }
}

std::size_t IpDefragmenter::pending() const {
  return static_cast<std::size_t>(
      std::count_if(slots_.begin(), slots_.end(), [](const Slot& s) { return s.used; }));
}

std::size_t IpDefragmenter::memory() const {
  std::size_t sum = 0;
  for (const Slot& slot : slots_) sum += slot.bytes.capacity() + slot.ranges.capacity() * sizeof(Range);
  return sum;
}

}  // namespace lidard
