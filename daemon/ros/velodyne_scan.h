// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/message_traits.h>
#include <ros/serialization.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/time.h"
#include "core/frames/device_message.h"

namespace lidard {

/// A velodyne_msgs/VelodyneScan as it travels: its bytes, so that the message package is not needed to build.
struct VelodyneScanBytes {
  std::vector<std::uint8_t> bytes;
};

/// Takes one data packet and when the sender of the message received it.
using PacketTaker = std::function<void(ByteView payload, Stamp arrival)>;

/// Hands on the packets of a VelodyneScan: a header, then a list of a stamp and 1206 bytes each
/// (velodyne_msgs/VelodyneScan.msg, VelodynePacket.msg). Returns nullptr, or what is wrong with the message;
/// then nothing is handed on.
const char* read_velodyne_scan(ByteView message, const PacketTaker& take);

/// The same the other way round.
void write_velodyne_scan(const RawPackets& packets, std::vector<std::uint8_t>& message);

}  // namespace lidard

namespace ros::message_traits {

template <>
struct MD5Sum<lidard::VelodyneScanBytes> {
  static const char* value() { return "50804fc9533a0e579e6322c04ae70566"; }
  static const char* value(const lidard::VelodyneScanBytes&) { return value(); }
};

template <>
struct DataType<lidard::VelodyneScanBytes> {
  static const char* value() { return "velodyne_msgs/VelodyneScan"; }
  static const char* value(const lidard::VelodyneScanBytes&) { return value(); }
};

/// The types without comments, which the MD5 leaves out, in the form of `gendeps --cat`: rosbag keeps it, and
/// whoever has no velodyne_msgs reads the messages by it.
template <>
struct Definition<lidard::VelodyneScanBytes> {
  static const char* value();
  static const char* value(const lidard::VelodyneScanBytes&) { return value(); }
};

/// roscpp numbers messages that begin with a header.
template <>
struct HasHeader<lidard::VelodyneScanBytes> : TrueType {};

}  // namespace ros::message_traits

namespace ros::serialization {

template <>
struct Serializer<lidard::VelodyneScanBytes> {
  template <typename Stream>
  static void read(Stream& stream, lidard::VelodyneScanBytes& message) {
    const std::uint32_t length = stream.getLength();
    const std::uint8_t* begin = stream.advance(length);
    message.bytes.assign(begin, begin + length);
  }
  template <typename Stream>
  static void write(Stream& stream, const lidard::VelodyneScanBytes& message) {
    const auto length = static_cast<std::uint32_t>(message.bytes.size());
    std::copy(message.bytes.begin(), message.bytes.end(), stream.advance(length));
  }
  static std::uint32_t serializedLength(const lidard::VelodyneScanBytes& message) {
    return static_cast<std::uint32_t>(message.bytes.size());
  }
};

}  // namespace ros::serialization
