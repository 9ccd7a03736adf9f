// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/time.h"
#include "core/frames/device_message.h"
#include "daemon/ros/messages/message_row.h"

namespace lidard {

/// A velodyne_msgs/VelodyneScan as bytes.
struct VelodyneScanMessage : CarriedMessage {
  static const MessageType& message_type();
  void all(ros::serialization::LStream& stream) const {
    stream.advance(static_cast<std::uint32_t>(bytes.size()));
  }
  void all(ros::serialization::OStream& stream) const {
    std::copy(bytes.begin(), bytes.end(), stream.advance(static_cast<std::uint32_t>(bytes.size())));
  }

  std::vector<std::uint8_t> bytes;
};

/// Called with each data packet and when the sender of the message received it.
using OnPacket = std::function<void(ByteView payload, HostStamp arrival)>;

/// Reads a VelodyneScan: a header, then a list of a stamp and 1206 bytes each
/// (velodyne_msgs/VelodyneScan.msg, VelodynePacket.msg). Returns nullptr, or the fault of the message; then
/// there was no call.
const char* read_velodyne_scan(ByteView message, const OnPacket& on_packet);

/// The packets of a Velodyne as a message.
void to_ros(const RawPackets& packets, HostStamp at, VelodyneScanMessage& message);
inline std::vector<MessageRow> velodyne_rows() { return {row<RawPackets, VelodyneScanMessage>(2)}; }

}  // namespace lidard
