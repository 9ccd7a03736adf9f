// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/sick/safety_messages.h"

#include <string_view>

#include "daemon/ros/messages/convert.h"
#include "drivers/sick/safety/ms3_telegram.h"

namespace lidard {

const MessageType& OutputPathsMessage::message_type() {
  static const MessageType type{
      "sick_safetyscanners/OutputPathsMsg", "10ce675a2a87077eb6fb8c168c348972",
      "bool[] status\nbool[] is_safe\nbool[] is_valid\nint32 active_monitoring_case\n"};
  return type;
}

const MessageType& ExtendedScanMessage::message_type() {
  static const MessageType type{
      "sick_safetyscanners/ExtendedLaserScanMsg", "ebb40b28432208d7bfa749af849de1ab",
      "sensor_msgs/LaserScan laser_scan\nbool[] reflektor_status\nbool[] reflektor_median\nbool[] "
      "intrusion\n" +
          definition_part("sensor_msgs/LaserScan", type_of<sensor_msgs::LaserScan>().definition)};
  return type;
}

void to_ros(const DeviceState& state, HostStamp /*at*/, OutputPathsMessage& message) {
  message.status.clear(), message.is_safe.clear(), message.is_valid.clear();
  // The values of the paths come in turn, path 1 first.
  const auto belongs = [](std::string_view name, std::string_view begin) {
    return name.substr(0, begin.size()) == begin;
  };
  for (const DeviceValue& value : state.values) {
    const auto flag = static_cast<std::uint8_t>(value.value != 0);
    if (value.name == "active_monitoring_case")
      message.active_monitoring_case = static_cast<std::int32_t>(value.value);
    else if (belongs(value.name, "status_"))
      message.status.push_back(flag);
    else if (belongs(value.name, "is_safe_"))
      message.is_safe.push_back(flag);
    else if (belongs(value.name, "is_valid_"))
      message.is_valid.push_back(flag);
  }
}

void to_ros(const PlanarScan& scan, HostStamp at, ExtendedScanMessage& message) {
  namespace flag = sick::ms3_beam;
  to_ros(scan, at, message.laser_scan);
  for (auto* flags : {&message.reflector, &message.reflector_median, &message.intrusion})
    flags->assign(scan.beams, 0);
  if (scan.flags.empty()) return;
  for (std::size_t i = 0; i < scan.beams; ++i) {
    message.reflector[i] = (scan.flags[i] & flag::reflector) != 0;
    message.intrusion[i] = (scan.flags[i] & flag::contamination) != 0;
  }
  // As getMedianReflectors(): the last beam always ends a run, and never begins one.
  const std::vector<std::uint8_t>& reflector = message.reflector;
  for (std::size_t begin = 0, end = 0; begin + 1 < scan.beams; begin = end + 1) {
    end = begin;
    if (reflector[begin] == 0) continue;
    while (end + 1 < scan.beams && reflector[end] != 0) ++end;
    message.reflector_median[begin + (end - begin) / 2] = 1;
  }
}

}  // namespace lidard
