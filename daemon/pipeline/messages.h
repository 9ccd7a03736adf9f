// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/base/pose.h"
#include "core/frames/cloud.h"
#include "core/frames/scan.h"
#include "daemon/config/config.h"
#include "drivers/driver.h"

namespace lidard {

/// Gets what other nodes publish, in the thread of the pipeline; `received` is when it came. A sensor is
/// named, since a message may be on its way while the configuration changes.
class MessageReceiver {
 public:
  virtual ~MessageReceiver() = default;
  /// By how much the clock that stamps the messages from now on is ahead of the arrivals: a simulator's.
  virtual void set_message_clock(Span ahead) = 0;
  /// A packet of a sensor with `packet_topic:`; its `arrival` is that at the node that received it.
  virtual void packet_message(const std::string& sensor, const Packet& packet, Stamp received) = 0;
  /// A message of a `topic:` source.
  virtual void scan_message(const std::string& sensor, PlanarScan& scan, Stamp received) = 0;
  virtual void cloud_message(const std::string& sensor, Cloud& cloud, Stamp received) = 0;
  /// A pose of `child` (empty: base_frame) in the odometry's frame, for deskewing.
  virtual void pose_message(Stamp stamp, const Pose& pose, const std::string& child, Stamp received) = 0;
  /// Turn rates in `frame`, rad/s, and the speed ahead, m/s: the vehicle's motion where nobody knows its
  /// poses.
  virtual void turn_message(Stamp stamp, const Eigen::Vector3d& rates, const std::string& frame,
                            Stamp received) = 0;
  virtual void speed_message(double speed, Stamp received) = 0;
  /// Gives a merged scan or a group of virtual scans another grid, profile or encoding from its next input
  /// on. Empty, or why it cannot be: then nothing changes.
  virtual std::string set_scan(const MakerId& maker, const OutputScanConfig& wanted) = 0;
  /// Gives the sensor of that name what of `wanted` may change while it runs. Empty, or why it cannot be.
  virtual std::string set_sensor(const SensorConfig& wanted) = 0;
};

}  // namespace lidard
