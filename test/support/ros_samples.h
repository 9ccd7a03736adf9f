// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/PointCloud2.h>

#include <cstddef>

#include "core/frames/cloud.h"
#include "core/frames/device_message.h"
#include "core/frames/scan.h"
#include "daemon/config/config.h"

namespace lidard::test {

/// Five beams from -1 to 1 rad: hit at 1 m, none, near, invalid, hit at 40 m; intensities 10 to 50.
PlanarScan sample_scan();
/// As it is published.
sensor_msgs::LaserScan sample_message();
/// A cloud of 16 rings with `points` distinct points, 0.1 ms apart.
Cloud sample_cloud(std::size_t points);
/// The message that the cloud is published as, after the host's clock was set by `step`.
sensor_msgs::PointCloud2 message_of(Cloud cloud, Span step = Span(0));
/// Converts a frame, where the host's clock was never set.
template <class Frame, class Message>
void to_message(const Frame& frame, Message& message) {
  to_ros(frame, HostStamp{frame.stamp.ns}, message);
}
/// A fix with corrections, of known altitude.
GnssFix sample_fix();
/// An instant that both clocks tell, from "gps_pps".
TimeReference sample_time_reference();
/// Turning left on level ground.
ImuSample sample_imu();

/// Topics of a vehicle with a scanner in front and a lidar with receiver and inertial unit on the roof.
inline const OutputTopic front_scan{"front/scan", TopicKind::scan, true, 0, 0};
inline const OutputTopic front_echoes{"front/echoes", TopicKind::echoes, true, 0, 1};
inline const OutputTopic roof_points{"roof/points", TopicKind::cloud, true, 0, 2};
inline const OutputTopic roof_fix{"roof/fix", TopicKind::message, false, message_kind<GnssFix>(), 3};
inline const OutputTopic roof_time{"roof/time_reference", TopicKind::message, false,
                                   message_kind<TimeReference>(), 4};
inline const OutputTopic roof_imu{"roof/imu", TopicKind::message, false, message_kind<ImuSample>(), 5};
/// All of them.
inline std::vector<OutputTopic> sample_topics() {
  return {front_scan, front_echoes, roof_points, roof_fix, roof_time, roof_imu};
}

}  // namespace lidard::test
