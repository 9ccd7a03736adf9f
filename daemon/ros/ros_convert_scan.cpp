// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "daemon/ros/ros_convert.h"

namespace lidard {
namespace {

bool all_finite(const sensor_msgs::LaserScan& m) {
  return std::isfinite(m.angle_min) && std::isfinite(m.angle_max) && std::isfinite(m.angle_increment);
}

/// True if the number of ranges is what the angles say, give or take one beam.
bool count_fits_angles(const sensor_msgs::LaserScan& m) {
  if (m.ranges.size() == 1) return true;
  const double span = static_cast<double>(m.angle_max) - static_cast<double>(m.angle_min);
  const double expected = span / static_cast<double>(m.angle_increment) + 1;
  return std::abs(expected - static_cast<double>(m.ranges.size())) < 1.5;
}

/// No scan takes longer; such a time counts something else.
constexpr float longest_scan_s = 60;

const char* what_is_wrong_in_time(const sensor_msgs::LaserScan& m) {
  if (!std::isfinite(m.time_increment)) return "time_increment is not finite";
  if (!std::isfinite(m.scan_time)) return "scan_time is not finite";
  if (m.time_increment < 0) return "time_increment is negative";
  if (m.time_increment * static_cast<float>(m.ranges.size()) > longest_scan_s)
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

bool intensities_fit(const sensor_msgs::LaserScan& message) {
  return message.intensities.empty() || message.intensities.size() == message.ranges.size();
}

const char* from_ros(const sensor_msgs::LaserScan& message, PlanarScan& scan) {
  const bool with_intensities = !message.intensities.empty() && intensities_fit(message);
  scan.frame_id = ros_frame(message.header.frame_id);
  scan.stamp = from_ros(message.header.stamp);
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
  return nullptr;
}

}  // namespace lidard
