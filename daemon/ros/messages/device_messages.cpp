// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/messages/device_messages.h"

#include <fmt/format.h>

#include "daemon/ros/messages/convert.h"

namespace lidard {
namespace {

void copy_vector(const Eigen::Vector3d& from, geometry_msgs::Vector3& to) {
  to.x = from.x();
  to.y = from.y();
  to.z = from.z();
}

}  // namespace

void to_ros(const GnssFix& fix, HostStamp at, sensor_msgs::NavSatFix& message) {
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

void to_ros(const TimeReference& reference, HostStamp at, sensor_msgs::TimeReference& message) {
  message.header.stamp = to_ros(at);
  message.time_ref = to_ros(reference.reference);
  message.source = reference.source;
}

void to_ros(const ImuSample& sample, HostStamp at, sensor_msgs::Imu& message) {
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
  copy_vector(sample.angular_velocity, message.angular_velocity);
  copy_vector(sample.linear_acceleration, message.linear_acceleration);
}

void to_ros(const DeviceState& state, HostStamp at, diagnostic_msgs::DiagnosticArray& message) {
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

}  // namespace lidard
