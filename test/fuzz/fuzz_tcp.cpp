// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Any segments, of eight bytes each: flags, connection, sequence number, length, time. A byte in the wrong
// place of a stream is a finding, and so is memory without bound.
#include <array>
#include <cstdlib>
#include <map>

#include "drivers/capture/tcp_reassembler.h"

namespace {

using namespace lidard;

/// Compares what comes with what was sent: each byte is the low byte of its sequence number.
class Checker {
 public:
  void take(const Packet& packet) {
    got += packet.payload.size();
    std::uint8_t& next = next_[{packet.from, packet.to}];
    next = packet.stream_start ? packet.payload.u8(0) : static_cast<std::uint8_t>(next + packet.missing);
    for (const std::uint8_t byte : packet.payload) {
      if (byte != next++) std::abort();
    }
  }
  std::uint64_t got = 0;

 private:
  std::map<std::pair<Endpoint, Endpoint>, std::uint8_t> next_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  TcpReassembler streams;
  Checker checker;
  const ByteView input(data, size);
  std::array<std::uint8_t, 256> bytes{};
  Stamp now{};
  Packet packet;
  const auto drain = [&] {
    while (streams.next(packet)) checker.take(packet);
    if (streams.waiting() > TcpReassembler::max_waiting_total + 256) std::abort();
    if (streams.streams() > TcpReassembler::max_streams) std::abort();
    if (checker.got != streams.counters().bytes) std::abort();
  };
  for (std::size_t at = 0; input.has(at, 8); at += 8) {
    TcpSegment segment;
    const std::uint8_t flags = input.u8(at);
    segment.fin = (flags & 1U) != 0, segment.syn = (flags & 2U) != 0, segment.rst = (flags & 4U) != 0;
    segment.ack = (flags & 16U) != 0;
    segment.from_port = input.u8(at + 1) & 3U;
    segment.to_port = input.u8(at + 1) >> 6U;
    segment.sequence = input.le16(at + 2) * ((flags & 8U) != 0 ? 65537U : 1U);
    segment.acknowledgement = segment.sequence;
    segment.length = input.u8(at + 4);
    const std::uint32_t kept = (flags & 32U) != 0 ? segment.length / 2 : segment.length;
    for (std::uint32_t i = 0; i < segment.length; ++i)
      bytes[i] = static_cast<std::uint8_t>(segment.sequence + (segment.syn ? 1U : 0U) + i);
    segment.payload = ByteView(bytes.data(), kept);
    now = now + std::chrono::milliseconds(input.le16(at + 5));
    streams.add(segment, IpAddress::v4(10, 0, 0, 1), IpAddress::v4(10, 0, 0, 2), now);
    drain();
  }
  streams.flush();
  drain();
  if (streams.waiting() != 0) std::abort();
  return 0;
}
