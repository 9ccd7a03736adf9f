// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <vector>

#include "drivers/capture/pcap_source.h"

namespace lidard::test {

using Bytes = std::vector<std::uint8_t>;

inline Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}
inline ByteView view(const Bytes& bytes) { return {bytes.data(), bytes.size()}; }

/// The low `n` bytes of `value`, highest first.
inline Bytes big(std::uint64_t value, std::size_t n) {
  Bytes out;
  for (std::size_t i = n; i-- > 0;) out.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  return out;
}
/// The low `n` bytes of `value`, lowest first.
inline Bytes little(std::uint64_t value, std::size_t n) {
  Bytes out = big(value, n);
  return {out.rbegin(), out.rend()};
}
/// `n` bytes that count up from `first`.
inline Bytes counting(std::size_t n, std::uint8_t first = 0) {
  Bytes out(n);
  for (std::size_t i = 0; i < n; ++i) out[i] = static_cast<std::uint8_t>(first + i);
  return out;
}

inline Bytes udp(const Bytes& payload, std::uint16_t from = 2368, std::uint16_t to = 2369) {
  return big(from, 2) + big(to, 2) + big(payload.size() + 8, 2) + big(0, 2) + payload;
}

/// Flags of a TCP header.
constexpr std::uint8_t tcp_fin = 1, tcp_syn = 2, tcp_rst = 4, tcp_ack = 16;

/// A TCP segment; options fill `options` bytes (a multiple of 4) with no-operations.
inline Bytes tcp(const Bytes& payload, std::uint32_t sequence, std::uint16_t from = 2112,
                 std::uint16_t to = 40000, std::uint8_t flags = tcp_ack, std::uint32_t acknowledged = 0,
                 std::size_t options = 0) {
  return big(from, 2) + big(to, 2) + big(sequence, 4) + big(acknowledged, 4) +
         Bytes{static_cast<std::uint8_t>((20 + options) / 4 << 4U), flags, 0xff, 0xff, 0, 0, 0, 0} +
         Bytes(options, 1) + payload;
}

struct V4 {
  std::uint8_t protocol = 17;
  std::uint16_t id = 0;
  std::size_t offset = 0;  ///< bytes
  bool more = false;
  Bytes options{};
  int lie = 0;  ///< added to the total length
  std::uint8_t last_of_sender = 201;
};
inline V4 of_tcp() {
  V4 o;
  o.protocol = 6;
  return o;
}
inline Bytes ipv4(const Bytes& transport, const V4& o = {}) {
  const std::size_t header = 20 + o.options.size();
  const auto total = static_cast<std::size_t>(static_cast<long>(header + transport.size()) + o.lie);
  return Bytes{static_cast<std::uint8_t>(0x40 | header / 4), 0} + big(total, 2) + big(o.id, 2) +
         big((o.more ? 0x2000U : 0U) | o.offset / 8, 2) + Bytes{64, o.protocol, 0, 0} +
         Bytes{192, 168, 1, o.last_of_sender} + Bytes{255, 255, 255, 255} + o.options + transport;
}
/// From fe80::1 to ff02::2.
inline Bytes ipv6(const Bytes& rest, std::uint8_t next = 17) {
  Bytes from(16), to(16);
  from[0] = 0xfe, from[1] = 0x80, from[15] = 1, to[0] = 0xff, to[1] = 2, to[15] = 2;
  return Bytes{0x60, 0, 0, 0} + big(rest.size(), 2) + Bytes{next, 64} + from + to + rest;
}
inline Bytes ipv6_fragment(const Bytes& part, std::uint32_t id, std::size_t offset, bool more,
                           std::uint8_t next = 17) {
  return ipv6(Bytes{next, 0} + big(offset | (more ? 1U : 0U), 2) + big(id, 4) + part, 44);
}
inline Bytes ethernet(const Bytes& payload, std::initializer_list<std::uint16_t> types = {0x0800}) {
  Bytes out(12, 0xaa);
  bool first = true;
  for (const auto type : types) {
    if (!first) out = out + Bytes{0, 7};  // the tag's priority and number
    first = false;
    out = out + big(type, 2);
  }
  return out + payload;
}

/// Builds a pcap file.
class PcapBytes {
 public:
  explicit PcapBytes(std::uint32_t link_type = 1, bool big_endian = false, std::uint32_t magic = 0xa1b2c3d4)
      : big_endian_(big_endian) {
    bytes = u(magic, 4) + u(2, 2) + u(4, 2) + u(0, 4) + u(0, 4) + u(65535, 4) + u(link_type, 4);
  }
  /// `length` 0: as long as the bytes.
  PcapBytes& add(const Bytes& frame, double t = 0, std::size_t length = 0) {
    const auto us = static_cast<std::uint64_t>(t * 1e6 + 0.5);
    bytes = bytes + u(us / 1000000, 4) + u(us % 1000000, 4) + u(frame.size(), 4) +
            u(length == 0 ? frame.size() : length, 4) + frame;
    return *this;
  }
  Bytes bytes;

 private:
  Bytes u(std::uint64_t value, std::size_t n) const { return big_endian_ ? big(value, n) : little(value, n); }
  bool big_endian_;
};

/// A file that lives in memory and has a path.
class MemoryFile {
 public:
  explicit MemoryFile(const Bytes& bytes) : MemoryFile(bytes.data(), bytes.size()) {}
  MemoryFile(const std::uint8_t* data, std::size_t size) : fd_(::memfd_create("capture", MFD_CLOEXEC)) {
    if (fd_ < 0 || ::write(fd_, data, size) != static_cast<ssize_t>(size)) throw std::runtime_error("memfd");
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() { ::close(fd_); }
  std::string path() const { return "/proc/self/fd/" + std::to_string(fd_); }

 private:
  int fd_;
};

/// A chunk of a TCP stream.
struct TcpChunk {
  Endpoint from, to;
  std::string bytes;
  Stamp arrival;
  bool stream_start = false;
  std::uint64_t missing = 0;
};

/// What a capture holds.
struct Contents {
  std::vector<std::string> payloads;
  std::vector<std::string> flows;  ///< "from > to", one per payload
  std::vector<Stamp> stamps;
  std::vector<TcpChunk> chunks;
  CaptureCounters counters;
  std::string error;  ///< of the source, or of the exception when it could not be opened
  bool opened = false;
  bool damaged = false;
};

inline void read_all(PcapSource& source, Contents& out) {
  Packet packet;
  while (source.next(packet)) {
    if (packet.transport == Transport::tcp) {
      out.chunks.push_back({packet.from, packet.to, std::string(packet.payload.text()), packet.arrival,
                            packet.stream_start, packet.missing});
      continue;
    }
    out.payloads.emplace_back(packet.payload.text());
    out.flows.push_back(packet.from.to_string() + " > " + packet.to.to_string());
    out.stamps.push_back(packet.arrival);
  }
  out.counters = source.counters();
  out.error = source.error();
  out.damaged = source.is_damaged();
}

inline Contents read_capture(const std::string& path) {
  Contents out;
  try {
    PcapSource source(path);
    out.opened = true;
    read_all(source, out);
  } catch (const CaptureError& error) {
    out.error = error.what();
  }
  return out;
}
inline Contents read_capture(const Bytes& bytes) { return read_capture(MemoryFile(bytes).path()); }

/// The rule of CaptureCounters: nothing vanishes.
inline bool adds_up(const CaptureCounters& c) {
  return c.frames + c.reassembled == c.datagrams + c.not_ip + c.tcp_segments + c.other_ip + c.truncated +
                                         c.malformed + c.unsupported_link + c.fragments &&
         c.fragments_dropped <= c.fragments;
}

inline std::string text(const Bytes& bytes) { return {bytes.begin(), bytes.end()}; }

}  // namespace lidard::test
