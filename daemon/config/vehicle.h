// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "drivers/key.h"

namespace lidard {

class Mapping;
struct Reading;

/// `vehicle:` of the configuration.
struct VehicleConfig {
  std::string base_frame = "base_link";
  std::vector<Eigen::Vector2d> footprint;  ///< m, base_frame; empty: no self filter
  std::string odometry_frame;              ///< poses of base_frame in it come from tf; empty: none
  std::string odometry_topic;              ///< or from a nav_msgs/Odometry topic; empty: none
  std::string imu_topic;    ///< or from turn rates (sensor_msgs/Imu) and a speed ahead; empty: none
  std::string speed_topic;  ///< geometry_msgs/TwistStamped; empty: none

  bool has_motion() const { return !odometry_frame.empty() || !odometry_topic.empty() || !imu_topic.empty(); }
};

Keys vehicle_keys(VehicleConfig& vehicle);
/// Reads the section; `reading` sees every name it gives away.
void read_vehicle(const Mapping& root, Reading& reading);

}  // namespace lidard
