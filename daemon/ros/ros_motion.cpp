// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/ros_motion.h"

#include <geometry_msgs/TwistStamped.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/Imu.h>

#include <atomic>
#include <utility>

#include "daemon/ros/ros_convert.h"
#include "daemon/ros/ros_reception.h"

namespace lidard {
namespace {

constexpr std::uint32_t queue_length = 50;

Pose pose_of(const geometry_msgs::Pose& message) {
  Pose pose = Pose::Identity();
  const auto& q = message.orientation;
  pose.linear() = Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized().toRotationMatrix();
  pose.translation() = Eigen::Vector3d(message.position.x, message.position.y, message.position.z);
  return pose;
}

template <typename Message, typename Use>
void subscribe(RosReception& reception, const std::string& topic, Use use) {
  if (topic.empty()) return;
  const boost::function<void(const boost::shared_ptr<const Message>&)> callback = [use](const auto& message) {
    use(*message);
  };
  // A pose that comes late by Nagle's algorithm is a scan that is not deskewed.
  reception.subscribers.push_back(reception.node.subscribe<Message>(topic, queue_length, callback, {},
                                                                    ros::TransportHints().tcpNoDelay()));
}

}  // namespace

struct RosMotion::Counts {
  std::atomic<std::uint64_t> poses{0}, turns{0}, speeds{0};
};

RosMotion::RosMotion(const VehicleConfig& vehicle, Post post, MotionHandlers handlers)
    : odometry_topic_(vehicle.odometry_topic),
      imu_topic_(vehicle.imu_topic),
      speed_topic_(vehicle.speed_topic),
      post_(std::move(post)),
      handlers_(std::move(handlers)),
      counts_(std::make_shared<Counts>()) {}

RosMotion::~RosMotion() = default;

void RosMotion::connected() {
  if (odometry_topic_.empty() && imu_topic_.empty()) return;
  reception_ = std::make_unique<RosReception>();
  subscribe<nav_msgs::Odometry>(
      *reception_, odometry_topic_,
      [counts = counts_, post = post_, use = handlers_.pose](const nav_msgs::Odometry& m) {
        ++counts->poses;
        post([use, stamp = from_ros(m.header.stamp), pose = pose_of(m.pose.pose), child = m.child_frame_id] {
          use(stamp, pose, child);
        });
      });
  subscribe<sensor_msgs::Imu>(
      *reception_, imu_topic_,
      [counts = counts_, post = post_, use = handlers_.turn](const sensor_msgs::Imu& m) {
        ++counts->turns;
        const Eigen::Vector3d rates(m.angular_velocity.x, m.angular_velocity.y, m.angular_velocity.z);
        post([use, stamp = from_ros(m.header.stamp), rates, frame = m.header.frame_id] {
          use(stamp, rates, frame);
        });
      });
  subscribe<geometry_msgs::TwistStamped>(
      *reception_, speed_topic_,
      [counts = counts_, post = post_, use = handlers_.speed](const geometry_msgs::TwistStamped& m) {
        ++counts->speeds;
        post([use, speed = m.twist.linear.x] { use(speed); });
      });
}

void RosMotion::disconnected(bool leave) { RosReception::end(reception_, leave); }

std::vector<DiagnosticItem> RosMotion::diagnostics() {
  std::vector<DiagnosticItem> items;
  const auto add = [&items](const std::string& topic, std::uint64_t messages) {
    if (topic.empty()) return;
    DiagnosticItem item;
    item.name = "motion " + topic;
    item.health = messages == 0 ? Health::warn : Health::ok;
    item.message = messages == 0 ? "nobody publishes " + topic + "; scans are not deskewed" : "receiving";
    item.values = {{"Topic", topic}, {"Messages", std::to_string(messages)}};
    items.push_back(std::move(item));
  };
  add(odometry_topic_, counts_->poses);
  add(imu_topic_, counts_->turns);
  add(speed_topic_, counts_->speeds);
  return items;
}

}  // namespace lidard
