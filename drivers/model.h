// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <string_view>
#include <vector>

#include "core/base/angle.h"
#include "drivers/driver.h"

namespace lidard {

/// What a sensor produces.
enum class FrameKind : std::uint8_t { scan, cloud };

/// An ability of some models. A key of the configuration that only some models accept names one of these.
enum class Trait : std::uint8_t {
  echoes,       ///< several echoes of a beam of a planar scanner
  revolutions,  ///< clouds are revolutions of firing sequences, which can be cut, organised and split by ring
  calibration,  ///< accepts a calibration file
  silent_beams_are_free,  ///< a beam without return proves that nothing is there, up to free_range()
  packet_messages,        ///< packets can also come in velodyne_msgs/VelodyneScan
  gnss,                   ///< sends the sentences of a satellite receiver to telemetry_port
  web_control,            ///< its settings are read and changed through its web interface
  settings_writable,      ///< settings can be changed over TCP, if allowed
  receiver_settable,      ///< streams over UDP and the receiver's address can be set over TCP
  logins,                 ///< has user levels with passwords
  skip_setting,           ///< can skip scans, by a setting of the device (CoLa)
  skip_request,           ///< can skip scans and merge beams, by the request for scans (SCIP)
  states_on_request,      ///< sends its states only on request (CoLa)
};

/// The traits of a model.
class Traits {
 public:
  constexpr Traits() = default;
  constexpr Traits(std::initializer_list<Trait> traits) { add(traits); }
  constexpr void add(Trait trait) { bits_ |= bit(trait); }
  constexpr void add(std::initializer_list<Trait> traits) {
    for (const Trait trait : traits) add(trait);
  }
  constexpr bool has(Trait trait) const { return (bits_ & bit(trait)) != 0; }

 private:
  static constexpr std::uint32_t bit(Trait trait) { return 1U << static_cast<unsigned>(trait); }
  std::uint32_t bits_ = 0;
};

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
  std::vector<MessageTopic> messages{};         ///< of DriverOutput::message()
  std::vector<std::string_view> extra_scans{};  ///< of DriverOutput::extra_scan()
  /// The ring nearest to the horizontal, of a multi-plane lidar; nullptr: not known.
  std::uint16_t (*level_ring)(const DriverConfig& config) = nullptr;
  const void* row = nullptr;  ///< the family's own table entry
  std::unique_ptr<Driver> (*make)(const DriverConfig& config) = nullptr;
  /// m: to here the device detects a target of 10 % remission, by its data sheet; 0: not known. So far a beam
  /// without return proves that nothing is there.
  double dark_range = 0;

  /// m that a beam without return proves free.
  double free_range() const { return dark_range > 0 ? std::min(dark_range, range_max) : range_max; }
  bool has(Trait trait) const { return traits.has(trait); }
  /// True if the device may send messages of this kind.
  template <class Kind>
  bool sends() const {
    return std::any_of(messages.begin(), messages.end(),
                       [](const MessageTopic& topic) { return topic.kind == message_kind<Kind>(); });
  }
};

}  // namespace lidard
