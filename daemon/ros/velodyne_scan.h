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
#include "daemon/ros/carried_message.h"

namespace lidard {

/// A velodyne_msgs/VelodyneScan as it travels: its bytes.
struct VelodyneScanForm {
  static constexpr const char* type = "velodyne_msgs/VelodyneScan";
  static constexpr const char* md5 = "50804fc9533a0e579e6322c04ae70566";
  static constexpr bool begins_with_header = true;
  static std::string definition();
  static void all(ros::serialization::IStream& stream, VelodyneScanForm& message) {
    const std::uint32_t length = stream.getLength();
    const std::uint8_t* begin = stream.advance(length);
    message.bytes.assign(begin, begin + length);
  }
  static void all(ros::serialization::OStream& stream, const VelodyneScanForm& message) {
    const auto length = static_cast<std::uint32_t>(message.bytes.size());
    std::copy(message.bytes.begin(), message.bytes.end(), stream.advance(length));
  }
  static void all(ros::serialization::LStream& stream, const VelodyneScanForm& message) {
    stream.advance(static_cast<std::uint32_t>(message.bytes.size()));
  }

  std::vector<std::uint8_t> bytes;
};
using VelodyneScanBytes = CarriedMessage<VelodyneScanForm>;

/// Takes one data packet and when the sender of the message received it.
using PacketTaker = std::function<void(ByteView payload, Stamp arrival)>;

/// Hands on the packets of a VelodyneScan: a header, then a list of a stamp and 1206 bytes each
/// (velodyne_msgs/VelodyneScan.msg, VelodynePacket.msg). Returns nullptr, or what is wrong with the message;
/// then nothing is handed on.
const char* read_velodyne_scan(ByteView message, const PacketTaker& take);

/// The same the other way round.
void write_velodyne_scan(const RawPackets& packets, std::vector<std::uint8_t>& message);

}  // namespace lidard
