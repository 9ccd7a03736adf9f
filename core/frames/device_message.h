// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "core/base/time.h"

namespace lidard {

/// How a satellite receiver found its position.
enum class FixStatus : std::uint8_t {
  none,       ///< no position, or one that is not from satellites (dead reckoning, simulation, manual)
  satellite,  ///< satellites alone
  sbas,       ///< with differential corrections
  gbas        ///< with a base station's carrier phase (RTK)
};

/// A position from a satellite receiver that is wired to the device.
struct GnssFix {
  static constexpr std::string_view topic = "fix";
  std::string frame_id;
  Stamp stamp;                                                      ///< host time of the position
  double latitude_deg = std::numeric_limits<double>::quiet_NaN();   ///< WGS 84, north positive
  double longitude_deg = std::numeric_limits<double>::quiet_NaN();  ///< WGS 84, east positive
  double altitude_m = std::numeric_limits<double>::quiet_NaN();  ///< above the WGS 84 ellipsoid; NaN unknown
  FixStatus status = FixStatus::none;
  std::optional<HostStamp> source_time;  ///< the receiver's own time (UTC), where it sends the date too
};

/// One instant on two clocks.
struct TimeReference {
  static constexpr std::string_view topic = "time_reference";
  Stamp stamp;
  HostStamp reference;  ///< on the other clock (UTC)
  std::string source;   ///< which other clock
};

/// One sample of an inertial unit, in the axes of `frame_id`. As measured, bias included.
struct ImuSample {
  static constexpr std::string_view topic = "imu";
  std::string frame_id;
  Stamp stamp;
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();     ///< rad/s
  Eigen::Vector3d linear_acceleration = Eigen::Vector3d::Zero();  ///< m/s²; at rest +g along what is up
  std::optional<Eigen::Quaterniond> orientation;  ///< turns these axes to those with z up; yaw from anywhere
};

/// One named value of a device's state; flags are 0 or 1. The name is a constant of the driver.
struct DeviceValue {
  std::string_view name;
  double value = 0;
};

/// Named values of a device: switching outputs, field evaluation, encoder, system state.
struct DeviceState {
  std::string_view topic;  ///< last part of the topic's name, a constant of the driver
  std::string frame_id;
  Stamp stamp;  ///< that of the scan it came with, else its own
  std::vector<DeviceValue> values;
};

/// Datagrams as received, all of one size, in order of arrival.
struct RawPackets {
  static constexpr std::string_view topic = "packets";
  std::string frame_id;
  Stamp stamp;                      ///< of the whole
  std::vector<Span> arrivals;       ///< of each packet, reckoned from `stamp`
  std::vector<std::uint8_t> bytes;  ///< the packets one after the other

  void clear() {
    arrivals.clear();
    bytes.clear();
  }
};

/// What a device sends beside its frames, or what is made of them. Each kind has a member `topic`, the last
/// part of its topic's name.
using DeviceMessage = std::variant<GnssFix, TimeReference, ImuSample, DeviceState, RawPackets>;

/// Index of a kind in that list, as of DeviceMessage::index().
template <class Kind, std::size_t index = 0>
constexpr std::size_t message_kind() {
  if constexpr (std::is_same_v<std::variant_alternative_t<index, DeviceMessage>, Kind>)
    return index;
  else
    return message_kind<Kind, index + 1>();
}

/// The last part of the name of a message's topic.
inline std::string_view topic_of(const DeviceMessage& message) {
  return std::visit([](const auto& kind) { return std::string_view(kind.topic); }, message);
}

/// A message that is filled again and again and keeps the memory of its texts and lists.
template <class Kind>
class ReusedMessage {
 public:
  Kind* operator->() { return std::get_if<Kind>(&message_); }
  operator const DeviceMessage&() const { return message_; }

 private:
  DeviceMessage message_ = Kind{};
};

}  // namespace lidard
