// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "core/base/angle.h"
#include "drivers/driver.h"
#include "drivers/traits.h"

namespace lidard {

/// What a sensor produces.
enum class FrameKind : std::uint8_t { scan, cloud };

/// Messages of one kind that a device sends beside its frames.
struct MessageTopic {
  std::string_view name;  ///< last part of the topic's name
  std::size_t kind;       ///< message_kind() of the topic
};
template <class Kind>
MessageTopic message_topic(std::string_view name = Kind::topic) {
  return {name, message_kind<Kind>()};
}

/// Where a product measures as it is delivered, for what is said without its data: a device may be set to
/// less.
struct FieldOfView {
  double first_deg = -180;  ///< azimuth of the first beam, counter-clockwise from ahead
  double step_deg = 0;
  std::size_t beams = 0;                 ///< of a plane; 0: not known
  std::vector<double> elevations_deg{};  ///< of the rings of a multi-plane lidar, upwards
  /// rad between the outer beams; 0: not known.
  double width() const {
    return beams < 2 ? 0 : std::abs(step_deg) * static_cast<double>(beams - 1) * rad_per_deg;
  }
};

/// The properties of a product that the program needs outside of its family. Properties of the protocol (beam
/// angles, firing times) are in the family's own table, at `row`.
struct Model {
  std::string_view name;      ///< as in the configuration, e.g. "velodyne_vlp16"
  std::string_view vendor;    ///< "Velodyne"
  std::string_view product;   ///< "VLP-16"
  std::string_view protocol;  ///< for people: "Velodyne data packet", "MS3 MD"
  std::string_view verified;  ///< how the decoder was tested, a few words for the table of models
  FrameKind kind = FrameKind::scan;
  Transport transport = Transport::udp;
  std::uint16_t port = 0;            ///< default UDP destination port of the data, or the device's TCP port
  std::uint16_t telemetry_port = 0;  ///< second UDP port of the device: GNSS, inertial unit; 0 none
  std::uint16_t dialogue_port = 0;   ///< TCP port of a UDP device's settings; 0 none
  double packets_per_s = 0;          ///< highest rate, all return modes; sizes the receive buffer
  double fragments_per_packet = 1;   ///< IP fragments of a usual datagram; sizes the receive buffer
  double frame_period = 0;           ///< s, usual
  double range_min = 0, range_max = 0;  ///< m, constant in every scan
  std::size_t beams = 0;                ///< rings of a multi-plane lidar; 0: the packets show it
  FieldOfView field{};
  Traits traits{};
  std::vector<MessageTopic> messages{};         ///< of FrameReceiver::message()
  std::vector<std::string_view> extra_scans{};  ///< of FrameReceiver::extra_scan()
  /// The ring nearest to the horizontal, of a multi-plane lidar; nullptr: not known.
  std::uint16_t (*level_ring)(const DriverConfig& config) = nullptr;
  const void* row = nullptr;  ///< the family's own table entry
  std::unique_ptr<Driver> (*make)(const DriverConfig& config) = nullptr;
  /// m: to here the device detects a target of 10 % remission, by its data sheet; 0: not known. So far a beam
  /// without return proves that nothing is there.
  double dark_range = 0;

  /// m that a beam without return proves free.
  double free_range() const { return dark_range > 0 ? std::min(dark_range, range_max) : range_max; }
  bool has(Trait trait) const {
    switch (trait) {
      case Trait::known:
        return true;
      case Trait::planar:
        return kind == FrameKind::scan;
      case Trait::multi_plane:
        return kind == FrameKind::cloud;
      case Trait::datagrams:
        return transport == Transport::udp;
      case Trait::scans:
        return kind == FrameKind::scan || traits.has(Trait::revolutions);
      case Trait::skips:
        return traits.has(Trait::skip_setting) || traits.has(Trait::skip_request);
      default:
        return traits.has(trait);
    }
  }
  /// True if the device may send messages of this kind.
  template <class Kind>
  bool sends() const {
    return std::any_of(messages.begin(), messages.end(),
                       [](const MessageTopic& topic) { return topic.kind == message_kind<Kind>(); });
  }
};

}  // namespace lidard
