// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include "daemon/ros/ros_convert.h"

namespace lidard {
namespace {

std::int8_t to_ros(FixStatus status) {
  using Status = sensor_msgs::NavSatStatus;
  switch (status) {
    case FixStatus::none:
      return Status::STATUS_NO_FIX;
    case FixStatus::satellite:
      return Status::STATUS_FIX;
    case FixStatus::sbas:
      return Status::STATUS_SBAS_FIX;
    case FixStatus::gbas:
      return Status::STATUS_GBAS_FIX;
  }
  return Status::STATUS_NO_FIX;
}

void copy_vector(const Eigen::Vector3d& from, geometry_msgs::Vector3& to) {
  to.x = from.x();
  to.y = from.y();
  to.z = from.z();
}

}  // namespace

void to_ros(const GnssFix& fix, sensor_msgs::NavSatFix& message) {
  message.header.stamp = to_ros(fix.stamp);
  message.header.frame_id = ros_frame(fix.frame_id);
  message.status.status = to_ros(fix.status);
  message.status.service = sensor_msgs::NavSatStatus::SERVICE_GPS;
  message.latitude = fix.latitude_deg;
  message.longitude = fix.longitude_deg;
  message.altitude = fix.altitude_m;
  message.position_covariance_type = sensor_msgs::NavSatFix::COVARIANCE_TYPE_UNKNOWN;
}

void to_ros(const TimeReference& reference, sensor_msgs::TimeReference& message) {
  message.header.stamp = to_ros(reference.stamp);
  message.time_ref = to_ros(reference.reference);
  message.source = reference.source;
}

void to_ros(const ImuSample& sample, sensor_msgs::Imu& message) {
  message.header.stamp = to_ros(sample.stamp);
  message.header.frame_id = ros_frame(sample.frame_id);
  if (sample.orientation) {
    message.orientation.w = sample.orientation->w();
    message.orientation.x = sample.orientation->x();
    message.orientation.y = sample.orientation->y();
    message.orientation.z = sample.orientation->z();
    message.orientation_covariance[0] = 0;  // sensor_msgs/Imu: all zero, not known
  } else {
    message.orientation = geometry_msgs::Quaternion();
    message.orientation_covariance[0] = -1;  // sensor_msgs/Imu: there is no orientation
  }
  copy_vector(sample.angular_velocity, message.angular_velocity);
  copy_vector(sample.linear_acceleration, message.linear_acceleration);
}

void to_ros(const DeviceState& state, diagnostic_msgs::DiagnosticArray& message) {
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

}  // namespace lidard
