// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "daemon/config/config.h"
#include "drivers/driver.h"

namespace lidard {

/// Collects the data packets of a revolution as they came, for SensorConfig::raw_topic. Its memory is kept
/// from one revolution to the next.
class RawPacketCollector {
 public:
  /// A VLS-128 in dual return mode at 300 rpm sends 3618 packets in a revolution.
  static constexpr std::size_t most_packets = 4000;

  /// Bytes of a velodyne_msgs/VelodynePacket.
  static constexpr std::size_t packet_size = 1206;

  /// `config` must outlive this.
  explicit RawPacketCollector(const SensorConfig& config) : config_(config) {}

  /// Takes a datagram; one that is no data packet by its size is left out.
  void add(const Packet& packet);
  /// True if the packets are to go out although no revolution has ended: the motor may stand still.
  bool is_full() { return message_->arrivals.size() >= most_packets; }
  bool is_empty() { return message_->arrivals.empty(); }
  /// The packets since clear(), of which there is at least one. Stamps are arrival times with the
  /// `time_offset`, as velodyne_driver gives them; the message has that of the first or of the last packet,
  /// as `frame_stamp` says.
  const DeviceMessage& message();
  void clear() { message_->clear(); }

 private:
  const SensorConfig& config_;
  ReusedMessage<RawPackets> message_;
  Stamp first_{};
};

}  // namespace lidard
