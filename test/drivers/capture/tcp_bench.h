// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "drivers/capture/tcp_reassembler.h"

namespace lidard::test::segments {

inline const IpAddress device = IpAddress::v4(192, 168, 0, 1);
inline const IpAddress host = IpAddress::v4(192, 168, 0, 99);

inline Stamp at(double seconds) { return Stamp{} + span_from_seconds(seconds); }

inline TcpSegment segment(std::uint32_t sequence, std::string_view bytes) {
  TcpSegment out;
  out.from_port = 2112, out.to_port = 40000;
  out.sequence = sequence;
  out.ack = true;
  out.payload = ByteView(bytes);
  out.length = static_cast<std::uint32_t>(bytes.size());
  return out;
}
inline TcpSegment syn(std::uint32_t sequence) {
  TcpSegment out = segment(sequence, "");
  out.syn = true;
  return out;
}

/// A reassembler and what came out of it.
struct TcpBench {
  TcpReassembler streams;
  std::vector<std::string> chunks;
  std::vector<std::uint64_t> missing;
  std::vector<bool> starts;
  std::vector<Stamp> stamps;

  void add(const TcpSegment& what, double t = 0) {
    streams.add(what, device, host, at(t));
    drain();
  }
  void answer(std::uint32_t acknowledgement, double t = 0) {
    TcpSegment out;
    out.from_port = 40000, out.to_port = 2112;
    out.ack = true;
    out.acknowledgement = acknowledgement;
    streams.add(out, host, device, at(t));
    drain();
  }
  void drain() {
    Packet packet;
    while (streams.next(packet)) {
      chunks.emplace_back(packet.payload.text());
      missing.push_back(packet.missing);
      starts.push_back(packet.stream_start);
      stamps.push_back(packet.arrival);
    }
  }
  void flush() {
    streams.flush();
    drain();
  }
  std::string all() const {
    std::string text;
    for (const auto& chunk : chunks) text += chunk;
    return text;
  }
};

}  // namespace lidard::test::segments
