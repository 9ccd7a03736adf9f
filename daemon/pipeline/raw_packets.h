// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "daemon/config/config.h"
#include "drivers/driver.h"

namespace lidard {

/// Collects the data packets of a revolution for SensorConfig::raw_topic. Keeps its memory.
class RawPacketCollector {
 public:
  /// A VLS-128 in dual return mode at 300 rpm sends 3618 packets in a revolution.
  static constexpr std::size_t most_packets = 4000;

  /// Bytes of a velodyne_msgs/VelodynePacket.
  static constexpr std::size_t packet_size = 1206;

  /// `config` must outlive this.
  explicit RawPacketCollector(const SensorConfig& config) : config_(config) {}

  /// Adds a datagram, unless its size is not that of a data packet.
  void add(const Packet& packet);
  /// True if the packet does not belong to the revolution of those before.
  bool is_broken_off_by(const Packet& packet) {
    constexpr Span longest_pause = std::chrono::seconds(1);
    return !is_empty() &&
           std::chrono::abs(packet.arrival - first_ - message_->arrivals.back()) > longest_pause;
  }
  /// True if the packets must be published before the end of the revolution: the motor may stand still.
  bool is_full() { return message_->arrivals.size() >= most_packets; }
  bool is_empty() { return message_->arrivals.empty(); }
  /// The packets since clear(), at least one. Stamps are arrival times plus `time_offset`, as in
  /// velodyne_driver; the stamp of the message is that of the first or the last packet, by `frame_stamp`.
  const DeviceMessage& message();
  void clear() { message_->clear(); }

 private:
  const SensorConfig& config_;
  ReusedMessage<RawPackets> message_;
  Stamp first_{};
};

}  // namespace lidard
