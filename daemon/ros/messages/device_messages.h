// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <diagnostic_msgs/DiagnosticArray.h>
#include <fmt/format.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/NavSatFix.h>
#include <sensor_msgs/TimeReference.h>

#include <vector>

#include "core/frames/device_message.h"
#include "daemon/ros/messages/convert.h"
#include "daemon/ros/messages/message_row.h"

/// \file
/// The messages of devices beside their frames: for each kind its conversion, and its row at the end. `at`:
/// the message's own stamp on the host's clock.
namespace lidard {

/// The covariance is unknown.
inline void to_ros(const GnssFix& fix, HostStamp at, sensor_msgs::NavSatFix& message) {
  using Status = sensor_msgs::NavSatStatus;
  static_assert(Status::STATUS_FIX == Status::STATUS_NO_FIX + 1 &&
                Status::STATUS_SBAS_FIX == Status::STATUS_NO_FIX + 2 &&
                Status::STATUS_GBAS_FIX == Status::STATUS_NO_FIX + 3);
  message.header.stamp = to_ros(at);
  message.header.frame_id = ros_frame(fix.frame_id);
  message.status.status = static_cast<std::int8_t>(Status::STATUS_NO_FIX + static_cast<int>(fix.status));
  message.status.service = Status::SERVICE_GPS;
  message.latitude = fix.latitude_deg;
  message.longitude = fix.longitude_deg;
  message.altitude = fix.altitude_m;
  message.position_covariance_type = sensor_msgs::NavSatFix::COVARIANCE_TYPE_UNKNOWN;
}

inline void to_ros(const TimeReference& reference, HostStamp at, sensor_msgs::TimeReference& message) {
  message.header.stamp = to_ros(at);
  message.time_ref = to_ros(reference.reference);
  message.source = reference.source;
}

/// The covariances are unknown.
inline void to_ros(const ImuSample& sample, HostStamp at, sensor_msgs::Imu& message) {
  message.header.stamp = to_ros(at);
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
  const auto copy = [](const Eigen::Vector3d& from, geometry_msgs::Vector3& to) {
    to.x = from.x(), to.y = from.y(), to.z = from.z();
  };
  copy(sample.angular_velocity, message.angular_velocity);
  copy(sample.linear_acceleration, message.linear_acceleration);
}

/// One status of an array, which has a stamp and needs no message package of ours; `topic` is its name.
inline void to_ros(const DeviceState& state, HostStamp at, diagnostic_msgs::DiagnosticArray& message) {
  message.header.stamp = to_ros(at);
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

inline std::vector<MessageRow> device_rows() {
  return {row<GnssFix, sensor_msgs::NavSatFix>(2), row<TimeReference, sensor_msgs::TimeReference>(2),
          row<ImuSample, sensor_msgs::Imu>(50), row<DeviceState, diagnostic_msgs::DiagnosticArray>(2)};
}

}  // namespace lidard
