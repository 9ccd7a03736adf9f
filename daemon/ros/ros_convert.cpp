// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/ros_convert.h"

#include <algorithm>
#include <limits>

namespace lidard {
namespace {

constexpr std::int64_t ns_per_s = 1'000'000'000;

template <typename Message>
void copy_geometry(const PlanarScan& scan, Message& message) {
  message.header.stamp = to_ros(scan.stamp);
  message.header.frame_id = ros_frame(scan.frame_id);
  message.angle_min = scan.angle_min;
  message.angle_max = scan.angle_max;
  message.angle_increment = scan.angle_increment;
  message.time_increment = scan.time_increment;
  message.scan_time = scan.scan_time;
  message.range_min = scan.range_min;
  message.range_max = scan.range_max;
}

sensor_msgs::PointField field(const char* name, std::uint32_t offset, std::uint8_t datatype) {
  sensor_msgs::PointField made;
  made.name = name;
  made.offset = offset;
  made.datatype = datatype;
  made.count = 1;
  return made;
}

/// The layout of CloudPoint.
const std::vector<sensor_msgs::PointField>& cloud_fields() {
  using Field = sensor_msgs::PointField;
  static const std::vector<Field> fields{field("x", offsetof(CloudPoint, x), Field::FLOAT32),
                                         field("y", offsetof(CloudPoint, y), Field::FLOAT32),
                                         field("z", offsetof(CloudPoint, z), Field::FLOAT32),
                                         field("intensity", offsetof(CloudPoint, intensity), Field::FLOAT32),
                                         field("ring", offsetof(CloudPoint, ring), Field::UINT16),
                                         field("time", offsetof(CloudPoint, time), Field::FLOAT32)};
  return fields;
}

/// The fields of CloudPoint and what CloudFormat adds; those of the last message are kept if they fit.
void set_fields(const CloudFormat& format, sensor_msgs::PointCloud2& message) {
  using Field = sensor_msgs::PointField;
  const std::size_t wanted = cloud_fields().size() + (format.confidence ? 1U : 0U) + (format.echo ? 1U : 0U);
  // Both formats with one more field differ in their point_step.
  if (message.fields.size() == wanted && message.point_step == format.point_step) return;
  message.fields = cloud_fields();
  if (format.confidence) message.fields.push_back(field("confidence", sizeof(CloudPoint), Field::UINT16));
  if (format.echo) message.fields.push_back(field("echo", format.point_step - 1, Field::UINT8));
}

void copy_echoes(const PlanarScan& scan, const std::vector<float>& values, std::size_t beam,
                 sensor_msgs::LaserEcho& echo) {
  echo.echoes.clear();
  for (std::size_t e = 0; e < scan.echoes; ++e) {
    const std::size_t i = scan.index(beam, e);
    if (e == 0 || scan.statuses[i] == BeamStatus::hit) echo.echoes.push_back(values[i]);
  }
}

}  // namespace

ros::Time to_ros(Stamp stamp) {
  constexpr std::int64_t latest = std::numeric_limits<std::uint32_t>::max() * ns_per_s + (ns_per_s - 1);
  const std::int64_t ns = std::clamp<std::int64_t>(stamp.ns, 0, latest);
  return {static_cast<std::uint32_t>(ns / ns_per_s), static_cast<std::uint32_t>(ns % ns_per_s)};
}

Stamp from_ros(const ros::Time& time) { return {time.sec * ns_per_s + time.nsec}; }

std::string ros_frame(const std::string& frame) {
  const auto first = frame.find_first_not_of('/');
  return first == std::string::npos ? std::string() : frame.substr(first);
}

void to_ros(const PlanarScan& scan, sensor_msgs::LaserScan& message) {
  copy_geometry(scan, message);
  const auto beams = static_cast<std::ptrdiff_t>(scan.beams);
  message.ranges.assign(scan.ranges.begin(), scan.ranges.begin() + beams);
  for (std::size_t b = 0; b < scan.beams; ++b) {
    if (scan.statuses[b] == BeamStatus::none) message.ranges[b] = scan.none_as;
    if (scan.statuses[b] == BeamStatus::invalid) message.ranges[b] = scan.invalid_as;
  }
  const auto intensities = scan.intensities.empty() ? 0 : beams;
  message.intensities.assign(scan.intensities.begin(), scan.intensities.begin() + intensities);
}

void to_ros(const PlanarScan& scan, sensor_msgs::MultiEchoLaserScan& message) {
  copy_geometry(scan, message);
  message.ranges.resize(scan.beams);
  message.intensities.resize(scan.intensities.empty() ? 0 : scan.beams);
  for (std::size_t b = 0; b < message.ranges.size(); ++b)
    copy_echoes(scan, scan.ranges, b, message.ranges[b]);
  for (std::size_t b = 0; b < message.intensities.size(); ++b)
    copy_echoes(scan, scan.intensities, b, message.intensities[b]);
}

void to_ros(Cloud& cloud, sensor_msgs::PointCloud2& message) {
  const bool organised = cloud.format.height > 0;
  message.header.stamp = to_ros(cloud.stamp);
  message.header.frame_id = ros_frame(cloud.frame_id);
  message.height = organised ? cloud.format.height : 1;
  message.width = static_cast<std::uint32_t>(cloud.size()) / message.height;
  set_fields(cloud.format, message);
  message.is_bigendian = 0;
  message.point_step = cloud.format.point_step;
  message.row_step = message.width * message.point_step;
  message.is_dense = organised ? 0 : 1;
  message.data.swap(cloud.points_bytes);
}

void to_ros(const std::vector<StaticTransform>& transforms, Stamp stamp, tf2_msgs::TFMessage& message) {
  message.transforms.clear();
  for (const auto& transform : transforms) {
    geometry_msgs::TransformStamped made;
    made.header.stamp = to_ros(stamp);
    made.header.frame_id = ros_frame(transform.parent);
    made.child_frame_id = ros_frame(transform.child);
    const Eigen::Vector3d xyz = transform.pose.translation();
    const Eigen::Quaterniond q = Eigen::Quaterniond(transform.pose.rotation()).normalized();
    made.transform.translation.x = xyz.x();
    made.transform.translation.y = xyz.y();
    made.transform.translation.z = xyz.z();
    made.transform.rotation.x = q.x();
    made.transform.rotation.y = q.y();
    made.transform.rotation.z = q.z();
    made.transform.rotation.w = q.w();
    message.transforms.push_back(std::move(made));
  }
}

void to_ros(const DiagnosticItem& item, diagnostic_msgs::DiagnosticStatus& status) {
  using Status = diagnostic_msgs::DiagnosticStatus;
  static_assert(
      Status::OK == static_cast<int>(Health::ok) && Status::WARN == static_cast<int>(Health::warn) &&
      Status::ERROR == static_cast<int>(Health::error) && Status::STALE == static_cast<int>(Health::stale));
  status.level = static_cast<std::int8_t>(item.health);
  status.message = item.message;
  status.hardware_id = item.hardware_id;
  for (const auto& [key, value] : item.values) {
    status.values.emplace_back();
    status.values.back().key = key;
    status.values.back().value = value;
  }
}

void to_ros(const std::vector<DiagnosticItem>& items, const std::string& node, Stamp stamp,
            diagnostic_msgs::DiagnosticArray& message) {
  message.header.stamp = to_ros(stamp);
  message.status.clear();
  for (const auto& item : items) {
    message.status.emplace_back();
    message.status.back().name = node + ": " + item.name;
    to_ros(item, message.status.back());
  }
}

}  // namespace lidard
