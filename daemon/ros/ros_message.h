// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <diagnostic_msgs/DiagnosticArray.h>
#include <fmt/format.h>
#include <rosgraph_msgs/Clock.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/NavSatFix.h>
#include <sensor_msgs/TimeReference.h>

#include <boost/mp11/algorithm.hpp>
#include <type_traits>
#include <utility>
#include <variant>

#include "core/frames/device_message.h"
#include "daemon/config/config.h"
#include "daemon/ros/ros_convert.h"
#include "daemon/ros/safety_messages.h"
#include "daemon/ros/velodyne_scan.h"

namespace lidard {

// How each kind of device message travels in ROS: ros_type() names the ROS message by its result and has no
// body, to_ros() fills it.

sensor_msgs::NavSatFix ros_type(const GnssFix& fix);
/// Its covariance is unknown.
inline void to_ros(const GnssFix& fix, sensor_msgs::NavSatFix& message) {
  using Status = sensor_msgs::NavSatStatus;
  static_assert(Status::STATUS_FIX == Status::STATUS_NO_FIX + 1 &&
                Status::STATUS_SBAS_FIX == Status::STATUS_NO_FIX + 2 &&
                Status::STATUS_GBAS_FIX == Status::STATUS_NO_FIX + 3);
  message.header.stamp = to_ros(fix.stamp);
  message.header.frame_id = ros_frame(fix.frame_id);
  message.status.status = static_cast<std::int8_t>(Status::STATUS_NO_FIX + static_cast<int>(fix.status));
  message.status.service = Status::SERVICE_GPS;
  message.latitude = fix.latitude_deg;
  message.longitude = fix.longitude_deg;
  message.altitude = fix.altitude_m;
  message.position_covariance_type = sensor_msgs::NavSatFix::COVARIANCE_TYPE_UNKNOWN;
}

sensor_msgs::TimeReference ros_type(const TimeReference& reference);
inline void to_ros(const TimeReference& reference, sensor_msgs::TimeReference& message) {
  message.header.stamp = to_ros(reference.stamp);
  message.time_ref = to_ros(reference.reference);
  message.source = reference.source;
}

inline void to_ros(const Eigen::Vector3d& from, geometry_msgs::Vector3& to) {
  to.x = from.x();
  to.y = from.y();
  to.z = from.z();
}

sensor_msgs::Imu ros_type(const ImuSample& sample);
/// Its covariances are unknown.
inline void to_ros(const ImuSample& sample, sensor_msgs::Imu& message) {
  message.header.stamp = to_ros(sample.stamp);
  message.header.frame_id = ros_frame(sample.frame_id);
  message.orientation = geometry_msgs::Quaternion();
  // sensor_msgs/Imu: -1, there is no orientation; all zero, its covariance is not known.
  message.orientation_covariance[0] = sample.orientation ? 0 : -1;
  if (sample.orientation) {
    message.orientation.w = sample.orientation->w();
    message.orientation.x = sample.orientation->x();
    message.orientation.y = sample.orientation->y();
    message.orientation.z = sample.orientation->z();
  }
  to_ros(sample.angular_velocity, message.angular_velocity);
  to_ros(sample.linear_acceleration, message.linear_acceleration);
}

diagnostic_msgs::DiagnosticArray ros_type(const DeviceState& state);
/// One status of an array, which has a stamp and needs no message package of ours; `topic` is its name.
inline void to_ros(const DeviceState& state, diagnostic_msgs::DiagnosticArray& message) {
  message.header.stamp = to_ros(state.stamp);
  message.header.frame_id = ros_frame(state.frame_id);
  message.status.resize(1);
  auto& status = message.status.front();
  status.name = state.topic;
  status.values.resize(state.values.size());
  for (std::size_t i = 0; i < state.values.size(); ++i) {
    status.values[i].key = state.values[i].name;
    status.values[i].value = fmt::format("{}", state.values[i].value);
  }
}

VelodyneScanBytes ros_type(const RawPackets& packets);
/// Those of a Velodyne.
inline void to_ros(const RawPackets& packets, VelodyneScanBytes& message) {
  write_velodyne_scan(packets, message.bytes);
}

template <class List>
struct RosMessageOf;
template <class... Told>
struct RosMessageOf<std::variant<Told...>> {
  template <class One>
  using RosType = decltype(ros_type(std::declval<const One&>()));
  using Type =
      boost::mp11::mp_unique<std::variant<sensor_msgs::LaserScan, sensor_msgs::MultiEchoLaserScan,
                                          sensor_msgs::PointCloud2, tf2_msgs::TFMessage, rosgraph_msgs::Clock,
                                          ExtendedScanMessage, OutputPathsMessage, RosType<Told>...>>;
  static Type empty(std::size_t kind) {
    static const Type all[] = {RosType<Told>()...};
    return all[kind];
  }
};
/// A message of any type that goes out: of topics of frames, of device messages, on /tf_static and on /clock.
using RosMessage = RosMessageOf<DeviceMessage>::Type;

/// An empty message of the type that travels on a topic.
inline RosMessage message_for(const OutputTopic& topic) {
  switch (topic.kind) {
    case TopicKind::scan:
      return sensor_msgs::LaserScan();
    case TopicKind::echoes:
      return sensor_msgs::MultiEchoLaserScan();
    case TopicKind::cloud:
      return sensor_msgs::PointCloud2();
    case TopicKind::extended_scan:
      return ExtendedScanMessage();
    case TopicKind::output_paths:
      return OutputPathsMessage();
    case TopicKind::message:
      return RosMessageOf<DeviceMessage>::empty(topic.message);
  }
  return {};
}

inline void to_ros(Stamp now, rosgraph_msgs::Clock& message) { message.clock = to_ros(now); }

/// Fills `message` with to_ros(); false if a frame of this kind does not become a message of the type that
/// `message` holds.
template <class Frame>
bool convert(Frame& frame, RosMessage& message) {
  if constexpr (std::is_same_v<std::remove_const_t<Frame>, DeviceMessage>) {
    return std::visit([&message](const auto& told) { return convert(told, message); }, frame);
  } else {
    const auto to_held_type = [&frame](auto& held) -> decltype(to_ros(frame, held)) { to_ros(frame, held); };
    return std::visit(
        [&](auto& held) {
          constexpr bool fits = std::is_invocable_v<decltype(to_held_type), decltype(held)>;
          if constexpr (fits) to_held_type(held);
          return fits;
        },
        message);
  }
}

}  // namespace lidard
