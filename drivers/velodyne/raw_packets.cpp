// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/raw_packets.h"

#include "drivers/velodyne/packet.h"

namespace lidard::velodyne {

void RawPacketCollector::add(const Packet& packet, FrameReceiver& out) {
  if (!stamp_) return;
  constexpr Span longest_pause = std::chrono::seconds(1);
  RawPackets& packets = *message_.operator->();
  const Span since_first = packet.arrival - first_;
  if (!packets.arrivals.empty() && std::chrono::abs(since_first - packets.arrivals.back()) > longest_pause)
    publish(out);
  if (packet.transport != Transport::udp || packet.payload.size() != packet_size) return;
  if (packets.arrivals.empty()) first_ = packet.arrival;
  packets.arrivals.push_back(packet.arrival - first_);
  packets.bytes.insert(packets.bytes.end(), packet.payload.begin(), packet.payload.end());
  if (packets.arrivals.size() >= most_packets) publish(out);
}

void RawPacketCollector::publish(FrameReceiver& out) {
  RawPackets& packets = *message_.operator->();
  if (packets.arrivals.empty()) return;
  packets.stamp = first_ + time_offset_;
  if (stamp_ != FrameStamp::first) {
    const Span last = packets.arrivals.back();
    for (Span& arrival : packets.arrivals) arrival -= last;
    packets.stamp = packets.stamp + last;
  }
  out.message(message_);
  clear();
}

}  // namespace lidard::velodyne
