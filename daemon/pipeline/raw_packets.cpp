// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/raw_packets.h"

namespace lidard {

void RawPacketCollector::add(const Packet& packet, Stamp now) {
  constexpr Span longest_pause = std::chrono::seconds(1);
  RawPackets& packets = *message_.operator->();
  const Span since_first = packet.arrival - first_;
  if (!packets.arrivals.empty() && std::chrono::abs(since_first - packets.arrivals.back()) > longest_pause)
    publish(now);
  if (packet.transport != Transport::udp || packet.payload.size() != packet_size) return;
  if (packets.arrivals.empty()) first_ = packet.arrival;
  packets.arrivals.push_back(packet.arrival - first_);
  packets.bytes.insert(packets.bytes.end(), packet.payload.begin(), packet.payload.end());
  if (packets.arrivals.size() >= most_packets) publish(now);
}

void RawPacketCollector::publish(Stamp now) {
  RawPackets& packets = *message_.operator->();
  if (packets.arrivals.empty()) return;
  packets.frame_id = config_.frame_id;
  packets.stamp = first_ + config_.driver.time_offset;
  if (config_.layout.stamp != FrameStamp::first) {
    const Span last = packets.arrivals.back();
    for (Span& arrival : packets.arrivals) arrival -= last;
    packets.stamp = packets.stamp + last;
  }
  const DeviceMessage& message = message_;
  topic_.deliver(message, now);
  clear();
}

}  // namespace lidard
