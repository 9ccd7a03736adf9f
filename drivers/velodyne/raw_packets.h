// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>

#include "drivers/driver.h"

namespace lidard::velodyne {

/// Hands on the data packets of each revolution, if DriverConfig::raw_packets asks for them. Keeps its
/// memory.
class RawPacketCollector {
 public:
  /// A VLS-128 in dual return mode at 300 rpm sends 3618 packets in a revolution.
  static constexpr std::size_t most_packets = 4000;

  explicit RawPacketCollector(const DriverConfig& config)
      : stamp_(config.raw_packets), time_offset_(config.time_offset) {
    message_->frame_id = config.frame_id;
  }
  void set_time_offset(Span offset) { time_offset_ = offset; }

  /// Adds a datagram, unless its size is not that of a data packet. Hands on those before it after a pause,
  /// and all when they are too many: the motor may stand still.
  void add(const Packet& packet, FrameReceiver& out);
  /// Hands on the packets since the last call, if any, as one message. Stamps are arrival times plus
  /// `time_offset`, as in velodyne_driver; the stamp of the message is that of the first or the last packet.
  void publish(FrameReceiver& out);
  void clear() { message_->clear(); }

 private:
  const std::optional<FrameStamp> stamp_;  // none: nothing is collected
  Span time_offset_;
  ReusedMessage<RawPackets> message_;
  Stamp first_{};
};

}  // namespace lidard::velodyne
