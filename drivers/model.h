// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/driver.h"

namespace lidard {

/// What a sensor produces.
enum class FrameKind : std::uint8_t { scan, cloud };

/// Messages of one kind that a device tells beside its frames.
struct MessageTopic {
  std::string_view name;  ///< last part of the topic's name
  std::size_t kind;       ///< message_kind() of what travels there
};
template <class Told>
MessageTopic message_topic(std::string_view name = Told::topic) {
  return {name, message_kind<Told>()};
}

/// Everything the rest of the program needs to know about one product. What only its protocol needs (beam
/// angles, firing times) stands in the family's own table, behind `row`.
struct Model {
  std::string_view name;      ///< as in the configuration, e.g. "velodyne_vlp16"
  std::string_view vendor;    ///< "Velodyne"
  std::string_view product;   ///< "VLP-16"
  std::string_view protocol;  ///< for people: "Velodyne data packet", "MS3 MD"
  FrameKind kind;
  Transport transport;
  std::uint16_t
      port;  ///< default: UDP destination port of the data, or the device's TCP port; 0: must be configured
  std::uint16_t telemetry_port;  ///< second UDP port of the device, 0 none: a satellite receiver's sentences
  double packets_per_s;          ///< highest rate, all return modes; sizes the receive buffer
  double frame_period;           ///< s, usual
  double range_min, range_max;   ///< m, constant in every scan
  std::size_t beams;             ///< rings of a multi-plane lidar; 0: the packets tell
  std::string_view verified;     ///< on what the decoder was tested, a few words for the table of models
  const void* row;               ///< the family's own table entry
  std::unique_ptr<Driver> (*make)(const DriverConfig& config);
  std::vector<MessageTopic> messages{};         ///< of DriverOutput::message()
  bool has_echoes = false;                      ///< it can send several echoes of a beam
  std::uint16_t dialogue_port = 0;              ///< TCP port of a UDP device's settings; 0 none
  std::vector<std::string_view> extra_scans{};  ///< of DriverOutput::extra_scan()
  bool telemetry_is_imu = false;                ///< what comes on telemetry_port is the inertial unit's

  bool has_confidence = false;  ///< it can vouch for each return (Cloud::confidences)
  /// The ring nearest to the horizontal, of a multi-plane lidar; nullptr: not known.
  std::uint16_t (*level_ring)(const DriverConfig& config) = nullptr;

  /// True if the device may tell messages of this kind.
  template <class Told>
  bool tells() const {
    return std::any_of(messages.begin(), messages.end(),
                       [](const MessageTopic& topic) { return topic.kind == message_kind<Told>(); });
  }
  bool has_gnss() const { return tells<GnssFix>(); }
};

}  // namespace lidard
