// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/ros/ros_component.h"

namespace lidard {

/// Subscribes to the topics that tell how the vehicle moves: nav_msgs/Odometry, or sensor_msgs/Imu with a
/// speed (geometry_msgs/TwistStamped).
class RosMotion : public RosComponent {
 public:
  RosMotion(const VehicleConfig& vehicle, RosPost post, RosHandlers handlers);

  void connected(RosCallbackThread& ros) override;
  std::vector<DiagnosticItem> diagnostics() override;

 private:
  template <typename Message, typename MakeTask>
  void subscribe(RosCallbackThread& ros, std::size_t topic, MakeTask make_task);

  enum Topic : std::size_t { odometry, imu, speed };
  const std::string topics_[3];  // empty: not to be heard
  const RosPost post_;
  const RosHandlers handlers_;
  std::atomic<std::uint64_t> messages_[3] = {};
};

}  // namespace lidard
