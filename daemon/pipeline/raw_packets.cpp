// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/raw_packets.h"

namespace lidard {

void RawPacketCollector::add(const Packet& packet) {
  if (packet.transport != Transport::udp || packet.payload.size() != packet_size) return;
  if (is_empty()) first_ = packet.arrival;
  message_->arrivals.push_back(packet.arrival - first_);
  message_->bytes.insert(message_->bytes.end(), packet.payload.begin(), packet.payload.end());
}

const DeviceMessage& RawPacketCollector::message() {
  RawPackets& packets = *message_.operator->();
  packets.frame_id = config_.frame_id;
  packets.stamp = first_ + config_.driver.time_offset;
  if (config_.layout.stamp == FrameStamp::first) return message_;
  const Span last = packets.arrivals.back();
  for (Span& arrival : packets.arrivals) arrival -= last;
  packets.stamp = packets.stamp + last;
  return message_;
}

}  // namespace lidard
