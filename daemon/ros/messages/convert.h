// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <diagnostic_msgs/DiagnosticArray.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/MultiEchoLaserScan.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2_msgs/TFMessage.h>

#include <cstddef>
#include <string>
#include <vector>

#include "core/base/host_clock.h"
#include "daemon/health/diagnostics.h"

namespace lidard {

/// A stamp as ROS has it. ros::Time reaches from 1970 to 2106; stamps outside are moved to its nearest end.
ros::Time to_ros(HostStamp stamp);
/// A ROS time as a stamp.
HostStamp from_ros(const ros::Time& time);
/// A frame name without leading slashes: tf2 refuses them.
std::string ros_frame(const std::string& frame);

/// A scan (its first echo) as sensor_msgs/LaserScan. The message's buffers are reused. `at`: the frame's own
/// stamp on the host's clock, here and below.
void to_ros(const PlanarScan& scan, HostStamp at, sensor_msgs::LaserScan& message);
/// A scan as sensor_msgs/MultiEchoLaserScan: each beam holds its first echo, hit or not, and the further
/// hits.
void to_ros(const PlanarScan& scan, HostStamp at, sensor_msgs::MultiEchoLaserScan& message);
/// A cloud as sensor_msgs/PointCloud2, but for its data.
void to_ros(const Cloud& cloud, HostStamp at, sensor_msgs::PointCloud2& message);
void to_ros(const MergedCloud& cloud, HostStamp at, sensor_msgs::PointCloud2& message);
/// Fixed transforms as tf2_msgs/TFMessage.
void to_ros(const std::vector<StaticTransform>& transforms, HostStamp at, tf2_msgs::TFMessage& message);
/// Status items as diagnostic_msgs/DiagnosticArray; names are prefixed "`node`: " (REP 107).
void to_ros(const std::vector<DiagnosticItem>& items, const std::string& node, HostStamp at,
            diagnostic_msgs::DiagnosticArray& message);
/// One of them without its name; the status has no values yet.
void to_ros(const DiagnosticItem& item, diagnostic_msgs::DiagnosticStatus& status);
/// Reads another driver's scan. Returns nullptr, or the fault of the message; `scan` is invalid then.
///
/// NaN is `invalid`, +inf `none`, -inf `near` (REP 117); a finite range outside the message's limits is
/// `invalid` (sensor_msgs/LaserScan: "should be discarded"). A negative increment is a scanner mounted upside
/// down and is kept when it agrees with the angles. One beam more or less than by the angles is rounding and
/// accepted. A message without ranges gives a `scan` without beams. Intensities of another number than the
/// ranges are left out.
const char* from_ros(const sensor_msgs::LaserScan& message, PlanarScan& scan,
                     const ClockStep& clock = ClockStep());
/// False if the message has intensities, but not one for each range.
bool intensities_fit(const sensor_msgs::LaserScan& message);

/// A position or translation and an orientation as a pose; the orientation need not be normalised. One that
/// is not filled in (all zero) makes a pose that is not rigid.
template <class Position>
Pose to_pose(const Position& at, const geometry_msgs::Quaternion& q) {
  Pose pose = Pose::Identity();
  const Eigen::Quaterniond turn(q.w, q.x, q.y, q.z);
  if (turn.norm() > 0.1)
    pose.linear() = turn.normalized().toRotationMatrix();
  else
    pose.linear().setZero();
  pose.translation() = Eigen::Vector3d(at.x, at.y, at.z);
  return pose;
}
inline Pose to_pose(const geometry_msgs::Transform& transform) {
  return to_pose(transform.translation, transform.rotation);
}

/// Result of reading a point cloud message.
struct CloudReading {
  const char* error = nullptr;  ///< the fault of the message; the cloud is invalid then
  std::size_t dropped = 0;      ///< points left out because a coordinate is not finite
};
/// Reads another driver's cloud: fields in any order, of any type and byte order, with padding; `ring`,
/// `intensity` and `time` (float, s after the stamp) are 0 where the message has none. The cloud has no
/// columns.
CloudReading from_ros(const sensor_msgs::PointCloud2& message, Cloud& cloud,
                      const ClockStep& clock = ClockStep());

}  // namespace lidard
