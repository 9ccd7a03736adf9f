// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <geometry_msgs/TwistStamped.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/Imu.h>

#include <atomic>
#include <utility>

#include "daemon/pipeline/pipeline.h"
#include "daemon/ros/in/component.h"
#include "daemon/ros/messages/convert.h"

namespace lidard {
namespace {

class RosMotion final : public RosComponent {
 public:
  RosMotion(const VehicleConfig& vehicle, RosPost post, SharedClockStep clock)
      : topics_{vehicle.odometry_topic, vehicle.imu_topic, vehicle.speed_topic},
        post_(std::move(post)),
        clock_(std::move(clock)) {}
  void connected(RosCallbackThread& ros) override {
    listen<nav_msgs::Odometry>(ros, odometry, [clock = clock_](const nav_msgs::Odometry& m) {
      return [stamp = clock->steady(from_ros(m.header.stamp)),
              pose = to_pose(m.pose.pose.position, m.pose.pose.orientation), child = m.child_frame_id](
                 auto& to, Stamp received) { to.pose_message(stamp, pose, child, received); };
    });
    listen<sensor_msgs::Imu>(ros, imu, [clock = clock_](const sensor_msgs::Imu& m) {
      const Eigen::Vector3d rates(m.angular_velocity.x, m.angular_velocity.y, m.angular_velocity.z);
      return [stamp = clock->steady(from_ros(m.header.stamp)), rates, frame = m.header.frame_id](
                 auto& to, Stamp received) { to.turn_message(stamp, rates, frame, received); };
    });
    listen<geometry_msgs::TwistStamped>(ros, speed, [](const auto& m) {
      return [ahead = m.twist.linear.x](auto& to, Stamp received) { to.speed_message(ahead, received); };
    });
  }

 private:
  enum Topic : std::size_t { odometry, imu, speed };
  template <typename Message, typename MakeTask>
  void listen(RosCallbackThread& ros, Topic topic, MakeTask make_task) {
    constexpr std::uint32_t queue_length = 50;
    if (topics_[topic].empty()) return;
    const auto receive = [this, make_task](const boost::shared_ptr<const Message>& message) {
      post_({}, make_task(*message));
    };
    // A pose that Nagle's algorithm delays is missing for deskewing.
    subscribe<Message>(ros, topics_[topic], queue_length, receive, type_of<Message>(),
                       ros::TransportHints().tcpNoDelay());
  }

  const std::string topics_[3];  // empty: none
  const RosPost post_;
  const SharedClockStep clock_;
};

}  // namespace

std::shared_ptr<RosComponent> make_ros_motion(const VehicleConfig& vehicle, RosPost post,
                                              SharedClockStep clock) {
  return std::make_shared<RosMotion>(vehicle, std::move(post), std::move(clock));
}

}  // namespace lidard
