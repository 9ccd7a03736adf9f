// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/messages/convert.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lidard {
namespace {

constexpr std::int64_t ns_per_s = 1'000'000'000;

template <typename Message>
void copy_geometry(const PlanarScan& scan, HostStamp at, Message& message) {
  message.header.stamp = to_ros(at);
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

template <class AnyCloud>
void copy_cloud(const AnyCloud& cloud, HostStamp at, std::size_t point_step,
                sensor_msgs::PointCloud2& message) {
  const bool organised = cloud.height > 0;
  message.header.stamp = to_ros(at);
  message.header.frame_id = ros_frame(cloud.frame_id);
  message.height = organised ? cloud.height : 1;
  message.width = static_cast<std::uint32_t>(cloud.size()) / message.height;
  if (message.fields.empty()) message.fields = cloud_fields();
  message.is_bigendian = 0;
  message.point_step = static_cast<std::uint32_t>(point_step);
  message.row_step = message.width * message.point_step;
  message.is_dense = organised ? 0 : 1;
}

void copy_echoes(const PlanarScan& scan, const std::vector<float>& values, std::size_t beam,
                 sensor_msgs::LaserEcho& echo) {
  echo.echoes.clear();
  for (std::size_t e = 0; e < scan.echoes; ++e) {
    const std::size_t i = scan.index(beam, e);
    if (e == 0 || scan.statuses[i] == BeamStatus::hit) echo.echoes.push_back(values[i]);
  }
}

bool all_finite(const sensor_msgs::LaserScan& m) {
  return std::isfinite(m.angle_min) && std::isfinite(m.angle_max) && std::isfinite(m.angle_increment);
}

/// True if the number of ranges fits the angles, within one beam.
bool count_fits_angles(const sensor_msgs::LaserScan& m) {
  if (m.ranges.size() == 1) return true;
  const double span = static_cast<double>(m.angle_max) - static_cast<double>(m.angle_min);
  const double expected = span / static_cast<double>(m.angle_increment) + 1;
  return std::abs(expected - static_cast<double>(m.ranges.size())) < 1.5;
}

/// Longest scan; a longer time has another meaning.
constexpr float longest_scan_s = 60;

const char* what_is_wrong_in_time(const sensor_msgs::LaserScan& m) {
  if (!std::isfinite(m.time_increment)) return "time_increment is not finite";
  if (!std::isfinite(m.scan_time)) return "scan_time is not finite";
  if (std::abs(m.time_increment) * static_cast<float>(m.ranges.size()) > longest_scan_s)
    return "time_increment makes the scan longer than 60 s";
  return nullptr;
}

const char* what_is_wrong(const sensor_msgs::LaserScan& m) {
  if (!all_finite(m)) return "angles are not finite";
  if (m.ranges.size() > 1 && m.angle_increment == 0.0F) return "angle_increment is 0";
  if (m.ranges.size() > 1 && (m.angle_max - m.angle_min) * m.angle_increment < 0.0F)
    return "angle_increment has the wrong sign for angle_min and angle_max";
  if (!count_fits_angles(m)) return "number of ranges does not fit angle_min, angle_max and angle_increment";
  if (!(m.range_min >= 0.0F && m.range_max > m.range_min)) return "range limits are not 0 <= min < max";
  return what_is_wrong_in_time(m);
}

void read_beam(float range, std::size_t i, PlanarScan& scan) {
  if (std::isinf(range)) {
    scan.set_without_hit(i, range > 0 ? BeamStatus::none : BeamStatus::near);
  } else if (range >= scan.range_min && range <= scan.range_max) {
    scan.set_hit(i, range);
  }
}

}  // namespace

ros::Time to_ros(HostStamp stamp) {
  constexpr std::int64_t latest = std::numeric_limits<std::uint32_t>::max() * ns_per_s + (ns_per_s - 1);
  const std::int64_t ns = std::clamp<std::int64_t>(stamp.ns, 0, latest);
  return {static_cast<std::uint32_t>(ns / ns_per_s), static_cast<std::uint32_t>(ns % ns_per_s)};
}

HostStamp from_ros(const ros::Time& time) { return {time.sec * ns_per_s + time.nsec}; }

std::string ros_frame(const std::string& frame) {
  const auto first = frame.find_first_not_of('/');
  return first == std::string::npos ? std::string() : frame.substr(first);
}

void to_ros(const PlanarScan& scan, HostStamp at, sensor_msgs::LaserScan& message) {
  copy_geometry(scan, at, message);
  const auto beams = static_cast<std::ptrdiff_t>(scan.beams);
  message.ranges.assign(scan.ranges.begin(), scan.ranges.begin() + beams);
  encode_ranges(scan, message.ranges.data());
  const auto intensities = scan.intensities.empty() ? 0 : beams;
  message.intensities.assign(scan.intensities.begin(), scan.intensities.begin() + intensities);
}

void to_ros(const PlanarScan& scan, HostStamp at, sensor_msgs::MultiEchoLaserScan& message) {
  copy_geometry(scan, at, message);
  message.ranges.resize(scan.beams);
  message.intensities.resize(scan.intensities.empty() ? 0 : scan.beams);
  for (std::size_t b = 0; b < message.ranges.size(); ++b)
    copy_echoes(scan, scan.ranges, b, message.ranges[b]);
  for (std::size_t b = 0; b < message.intensities.size(); ++b)
    copy_echoes(scan, scan.intensities, b, message.intensities[b]);
}

void to_ros(const Cloud& cloud, HostStamp at, sensor_msgs::PointCloud2& message) {
  copy_cloud(cloud, at, sizeof(CloudPoint), message);
}

void to_ros(const MergedCloud& cloud, HostStamp at, sensor_msgs::PointCloud2& message) {
  copy_cloud(cloud, at, sizeof(MergedPoint), message);
  if (message.fields.size() == cloud_fields().size())
    message.fields.push_back(field("sensor", offsetof(MergedPoint, sensor), sensor_msgs::PointField::UINT16));
}

void to_ros(const std::vector<StaticTransform>& transforms, HostStamp at, tf2_msgs::TFMessage& message) {
  message.transforms.clear();
  for (const auto& transform : transforms) {
    geometry_msgs::TransformStamped made;
    made.header.stamp = to_ros(at);
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

void to_ros(const std::vector<DiagnosticItem>& items, const std::string& node, HostStamp at,
            diagnostic_msgs::DiagnosticArray& message) {
  message.header.stamp = to_ros(at);
  message.status.clear();
  for (const auto& item : items) {
    message.status.emplace_back();
    message.status.back().name = node + ": " + item.name;
    to_ros(item, message.status.back());
  }
}

bool intensities_fit(const sensor_msgs::LaserScan& message) {
  return message.intensities.empty() || message.intensities.size() == message.ranges.size();
}

const char* from_ros(const sensor_msgs::LaserScan& message, PlanarScan& scan, const ClockStep& clock) {
  const bool with_intensities = !message.intensities.empty() && intensities_fit(message);
  scan.frame_id = ros_frame(message.header.frame_id);
  scan.stamp = clock.steady(from_ros(message.header.stamp));
  scan.reset(message.ranges.size(), 1, with_intensities);
  if (message.ranges.empty()) return nullptr;
  if (const char* wrong = what_is_wrong(message)) return wrong;
  scan.set_angles(message.angle_min, message.angle_increment);
  scan.time_increment = message.time_increment;
  scan.scan_time = message.scan_time;
  scan.range_min = message.range_min;
  scan.range_max = message.range_max;
  for (std::size_t i = 0; i < message.ranges.size(); ++i) read_beam(message.ranges[i], i, scan);
  if (with_intensities) scan.intensities = message.intensities;
  // Here beams are in the order in which they were measured.
  if (scan.time_increment < 0) scan.reverse();
  return nullptr;
}

}  // namespace lidard
