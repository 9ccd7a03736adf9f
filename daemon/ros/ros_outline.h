// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <geometry_msgs/PolygonStamped.h>

#include "daemon/ros/ros_callback_thread.h"
#include "daemon/ros/ros_component.h"
#include "daemon/ros/ros_convert.h"

namespace lidard {

/// Where the outline of the vehicle is published, if it has one.
constexpr const char* outline_topic = "footprint";

/// The outline of the vehicle, at any time.
inline geometry_msgs::PolygonStamped outline_of(const VehicleConfig& vehicle) {
  geometry_msgs::PolygonStamped message;
  message.header.frame_id = ros_frame(vehicle.base_frame);
  for (const Eigen::Vector2d& vertex : vehicle.footprint) {
    geometry_msgs::Point32 point;
    point.x = static_cast<float>(vertex.x());
    point.y = static_cast<float>(vertex.y());
    message.polygon.points.push_back(point);
  }
  return message;
}

/// Publishes the outline of the vehicle, latched.
class RosOutline final : public RosComponent {
 public:
  explicit RosOutline(const VehicleConfig& vehicle) : outline_(outline_of(vehicle)) {}
  void connected(RosCallbackThread& ros) override {
    if (outline_.polygon.points.empty()) return;
    auto publisher = ros.node().advertise<geometry_msgs::PolygonStamped>(outline_topic, 1, true);
    publisher.publish(outline_);
    ros.keep(publisher);
  }

 private:
  const geometry_msgs::PolygonStamped outline_;
};

}  // namespace lidard
