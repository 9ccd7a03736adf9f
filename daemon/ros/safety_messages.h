// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sensor_msgs/LaserScan.h>

#include <cstdint>
#include <string>
#include <vector>

#include "core/frames/device_message.h"
#include "core/frames/scan.h"
#include "daemon/ros/carried_message.h"

namespace lidard {

// Messages of sick_safetyscanners 1.0.9 (msg/, src/SickSafetyscannersRos.cpp). A truth value is a byte.

struct OutputPathsForm {
  static constexpr const char* type = "sick_safetyscanners/OutputPathsMsg";
  static constexpr const char* md5 = "10ce675a2a87077eb6fb8c168c348972";
  static constexpr bool begins_with_header = false;
  static std::string definition();
  template <class Stream, class Message>
  static void all(Stream& stream, Message& message) {
    stream.next(message.status);
    stream.next(message.is_safe);
    stream.next(message.is_valid);
    stream.next(message.active_monitoring_case);
  }

  std::vector<std::uint8_t> status, is_safe, is_valid;  ///< one for each cut-off path
  std::int32_t active_monitoring_case = 0;
};
using OutputPathsMessage = CarriedMessage<OutputPathsForm>;

struct ExtendedScanForm {
  static constexpr const char* type = "sick_safetyscanners/ExtendedLaserScanMsg";
  static constexpr const char* md5 = "ebb40b28432208d7bfa749af849de1ab";
  static constexpr bool begins_with_header = false;
  static std::string definition();
  template <class Stream, class Message>
  static void all(Stream& stream, Message& message) {
    stream.next(message.laser_scan);
    stream.next(message.reflector);
    stream.next(message.reflector_median);
    stream.next(message.intrusion);
  }

  sensor_msgs::LaserScan laser_scan;
  // One for each range.
  std::vector<std::uint8_t> reflector;
  std::vector<std::uint8_t> reflector_median;  ///< of each run of reflectors the middle
  std::vector<std::uint8_t> intrusion;         ///< the flag of contamination, as in sick_safetyscanners
};
using ExtendedScanMessage = CarriedMessage<ExtendedScanForm>;

/// The state on the topic output_paths of a safety scanner (SafetyTopics).
void to_ros(const DeviceState& state, OutputPathsMessage& message);
/// A scan of a safety scanner with the flags of its beams.
void to_ros(const PlanarScan& scan, ExtendedScanMessage& message);

}  // namespace lidard
