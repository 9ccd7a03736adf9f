// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "daemon/pipeline/router.h"

namespace lidard {

/// Publishes the data packets of each revolution on SensorConfig::raw_topic. Keeps its memory.
class RawPacketCollector {
 public:
  /// A VLS-128 in dual return mode at 300 rpm sends 3618 packets in a revolution.
  static constexpr std::size_t most_packets = 4000;

  /// Bytes of a velodyne_msgs/VelodynePacket.
  static constexpr std::size_t packet_size = 1206;

  /// The arguments must outlive this.
  RawPacketCollector(const SensorConfig& config, Route& topic) : config_(config), topic_(topic) {}

  /// Adds a datagram, unless its size is not that of a data packet. Publishes those before it after a pause,
  /// and all when they are too many: the motor may stand still.
  void add(const Packet& packet, Stamp now);
  /// Publishes the packets since the last call, if any, as one message. Stamps are arrival times plus
  /// `time_offset`, as in velodyne_driver; the stamp of the message is that of the first or the last packet,
  /// by `frame_stamp`.
  void publish(Stamp now);
  void clear() { message_->clear(); }

 private:
  const SensorConfig& config_;
  Route& topic_;
  ReusedMessage<RawPackets> message_;
  Stamp first_{};
};

}  // namespace lidard
