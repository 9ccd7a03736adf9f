// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/velodyne/velodyne_scan.h"

#include <std_msgs/Header.h>

#include <cstring>
#include <string>

#include "daemon/ros/messages/convert.h"
#include "drivers/velodyne/packet.h"

namespace lidard {
namespace {

constexpr std::size_t header_numbers = 12;  // seq, seconds, nanoseconds
constexpr std::size_t stamp_bytes = 8;
constexpr std::size_t record = stamp_bytes + velodyne::packet_size;
/// A scan of a VLS-128 in dual return mode at 300 rpm has 3618 packets.
constexpr std::size_t most_packets = 20000;

HostStamp stamp_at(ByteView bytes, std::size_t at) {
  return {std::int64_t{bytes.le32(at)} * 1'000'000'000 + std::int64_t{bytes.le32(at + 4)}};
}

}  // namespace

const char* read_velodyne_scan(ByteView message, const OnPacket& on_packet) {
  const char* const cut_off = "the message is shorter than its own counts say";
  std::size_t at = header_numbers;
  if (message.size() < at + 4) return cut_off;
  const std::size_t name = message.le32(at);
  at += 4;
  if (name > message.size() - at || message.size() - at - name < 4) return cut_off;
  at += name;
  const std::size_t count = message.le32(at);
  at += 4;
  if (count > most_packets) return "the message counts more packets than a scan can have";
  if (message.size() - at < count * record) return cut_off;
  if (message.size() - at > count * record) return "the message is longer than its own counts say";
  for (std::size_t i = 0; i < count; ++i, at += record)
    on_packet(message.sub(at + stamp_bytes, velodyne::packet_size), stamp_at(message, at));
  return nullptr;
}

void to_ros(const RawPackets& packets, HostStamp at, VelodyneScanMessage& message) {
  std_msgs::Header header;
  header.stamp = to_ros(at);
  header.frame_id = ros_frame(packets.frame_id);
  const std::size_t count = packets.arrivals.size();
  std::vector<std::uint8_t>& bytes = message.bytes;
  bytes.resize(ros::serialization::serializationLength(header) + 4 + count * record);
  ros::serialization::OStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  stream.next(header);
  stream.next(static_cast<std::uint32_t>(count));
  for (std::size_t i = 0; i < count; ++i) {
    stream.next(to_ros(at + packets.arrivals[i]));
    std::memcpy(stream.advance(velodyne::packet_size), packets.bytes.data() + i * velodyne::packet_size,
                velodyne::packet_size);
  }
}

const MessageType& VelodyneScanMessage::message_type() {
  // The packages' own .msg files; std_msgs is in Debian.
  static const MessageType type{
      "velodyne_msgs/VelodyneScan", "50804fc9533a0e579e6322c04ae70566",
      "Header header\nVelodynePacket[] packets\n" +
          definition_part("std_msgs/Header", type_of<std_msgs::Header>().definition) + "\n" +
          definition_part("velodyne_msgs/VelodynePacket", "time stamp\nuint8[1206] data\n"),
      true};
  return type;
}

}  // namespace lidard
