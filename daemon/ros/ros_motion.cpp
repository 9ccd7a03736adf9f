// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/ros_motion.h"

#include <geometry_msgs/TwistStamped.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/Imu.h>

#include <utility>

#include "daemon/ros/ros_callback_thread.h"
#include "daemon/ros/ros_convert.h"

namespace lidard {
namespace {

constexpr std::uint32_t queue_length = 50;

}  // namespace

RosMotion::RosMotion(const VehicleConfig& vehicle, RosPost post, RosHandlers handlers)
    : topics_{vehicle.odometry_topic, vehicle.imu_topic, vehicle.speed_topic},
      post_(std::move(post)),
      handlers_(std::move(handlers)) {}

template <typename Message, typename MakeTask>
void RosMotion::subscribe(RosCallbackThread& ros, std::size_t topic, MakeTask make_task) {
  if (topics_[topic].empty()) return;
  // A pose that comes late by Nagle's algorithm is a scan that is not deskewed.
  ros.subscribe<Message>(
      topics_[topic], queue_length,
      [this, topic, make_task](const boost::shared_ptr<const Message>& message) {
        ++messages_[topic];
        post_(make_task(*message));
      },
      ros::TransportHints().tcpNoDelay());
}

void RosMotion::connected(RosCallbackThread& ros) {
  subscribe<nav_msgs::Odometry>(ros, odometry, [use = handlers_.pose](const nav_msgs::Odometry& m) {
    return
        [use, stamp = from_ros(m.header.stamp), pose = to_pose(m.pose.pose.position, m.pose.pose.orientation),
         child = m.child_frame_id](Stamp received) { use(stamp, pose, child, received); };
  });
  subscribe<sensor_msgs::Imu>(ros, imu, [use = handlers_.turn](const sensor_msgs::Imu& m) {
    const Eigen::Vector3d rates(m.angular_velocity.x, m.angular_velocity.y, m.angular_velocity.z);
    return [use, stamp = from_ros(m.header.stamp), rates, frame = m.header.frame_id](Stamp received) {
      use(stamp, rates, frame, received);
    };
  });
  subscribe<geometry_msgs::TwistStamped>(ros, speed, [use = handlers_.speed](const auto& m) {
    return [use, ahead = m.twist.linear.x](Stamp) { use(ahead); };
  });
}

std::vector<DiagnosticItem> RosMotion::diagnostics() {
  std::vector<DiagnosticItem> items;
  for (const Topic i : {odometry, imu, speed}) {
    const std::string& topic = topics_[i];
    const std::uint64_t messages = messages_[i];
    if (topic.empty()) continue;
    DiagnosticItem item;
    item.name = "motion " + topic;
    item.health = messages == 0 ? Health::warn : Health::ok;
    item.message = messages == 0 ? "nobody publishes " + topic + "; scans are not deskewed" : "receiving";
    item.values = {{"Topic", topic}, {"Messages", std::to_string(messages)}};
    items.push_back(std::move(item));
  }
  return items;
}

}  // namespace lidard
