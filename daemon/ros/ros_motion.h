// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/base/pose.h"
#include "core/base/time.h"
#include "daemon/config/config.h"
#include "daemon/ros/ros_link.h"

namespace lidard {

struct RosReception;

/// Where the messages about the vehicle's motion go; called in the sensor thread.
struct MotionHandlers {
  /// Pose of the message's child frame in the frame of the odometry.
  std::function<void(Stamp stamp, const Pose& pose, const std::string& child)> pose;
  /// Turn rates, rad/s, in `frame`.
  std::function<void(Stamp stamp, const Eigen::Vector3d& rates, const std::string& frame)> turn;
  /// Speed ahead, m/s.
  std::function<void(double speed)> speed;
};

/// Subscribes to the topics that tell how the vehicle moves: nav_msgs/Odometry, or sensor_msgs/Imu with a
/// speed (geometry_msgs/TwistStamped).
class RosMotion : public RosClient {
 public:
  /// Runs a function in the sensor thread.
  using Post = std::function<void(std::function<void()>)>;

  RosMotion(const VehicleConfig& vehicle, Post post, MotionHandlers handlers);
  ~RosMotion() override;

  void connected() override;
  void disconnected(bool leave) override;
  std::vector<DiagnosticItem> diagnostics() override;

 private:
  struct Counts;

  std::string odometry_topic_, imu_topic_, speed_topic_;
  Post post_;
  MotionHandlers handlers_;
  std::shared_ptr<Counts> counts_;
  std::unique_ptr<RosReception> reception_;
};

}  // namespace lidard
