// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sensor_msgs/LaserScan.h>

#include <cstdint>
#include <vector>

#include "core/frames/device_message.h"
#include "core/frames/scan.h"
#include "daemon/ros/messages/message_row.h"

namespace lidard {

// Messages of sick_safetyscanners 1.0.9 (msg/, src/SickSafetyscannersRos.cpp). A truth value is a byte.

struct OutputPathsMessage : CarriedMessage {
  static const MessageType& message_type();
  template <class Stream>
  void all(Stream& stream) const {
    stream.next(status);
    stream.next(is_safe);
    stream.next(is_valid);
    stream.next(active_monitoring_case);
  }

  std::vector<std::uint8_t> status, is_safe, is_valid;  ///< one for each cut-off path
  std::int32_t active_monitoring_case = 0;
};

struct ExtendedScanMessage : CarriedMessage {
  static const MessageType& message_type();
  template <class Stream>
  void all(Stream& stream) const {
    stream.next(laser_scan);
    stream.next(reflector);
    stream.next(reflector_median);
    stream.next(intrusion);
  }

  sensor_msgs::LaserScan laser_scan;
  // One for each range.
  std::vector<std::uint8_t> reflector;
  std::vector<std::uint8_t> reflector_median;  ///< the middle of each run of reflectors
  std::vector<std::uint8_t> intrusion;         ///< the flag of contamination, as in sick_safetyscanners
};

/// The state on the topic output_paths of a safety scanner (SafetyTopics).
void to_ros(const DeviceState& state, HostStamp at, OutputPathsMessage& message);
/// A scan of a safety scanner with the flags of its beams.
void to_ros(const PlanarScan& scan, HostStamp at, ExtendedScanMessage& message);
inline std::vector<MessageRow> safety_rows() {
  return {row<PlanarScan, ExtendedScanMessage>(TopicKind::extended_scan, 100),
          row<DeviceState, OutputPathsMessage>(TopicKind::output_paths, 100)};
}

}  // namespace lidard
