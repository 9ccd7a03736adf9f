// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <atomic>
#include <boost/shared_array.hpp>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "daemon/ros/ros_convert.h"
#include "daemon/ros/ros_device_message.h"
#include "daemon/ros/ros_queue.h"

namespace lidard {

/// The publishers of all output topics. The master thread advertises, the ROS thread publishes.
class RosPublishers {
 public:
  /// `topics` as in output_topics().
  RosPublishers(std::vector<OutputTopic> topics, bool clock);

  /// Advertises everything; ROS must run. Called by the master thread, may wait for the master.
  void advertise();
  /// Withdraws topics and advertises them anew, so that subscribers see a new publisher. Called like
  /// advertise(); frames of these topics are lost meanwhile.
  void advertise_again(const std::vector<std::string>& topics);
  /// Withdraws everything. With `leave` nothing is told to roscpp, whose destructors wait for the master.
  void drop(bool leave);
  bool ready() const { return ready_; }

  /// Converts and publishes; false if nothing is advertised. Fixed transforms are kept for later then.
  bool publish(QueuedFrame& frame);
  /// Messages of the frame's topic that some subscriber's socket has not yet taken.
  std::size_t in_flight(const QueuedFrame& frame);
  /// The same of all topics.
  std::size_t in_flight();
  /// Subscribers of all frame topics together; the last known number while a frame is being published.
  std::size_t subscribers() const;
  /// ROS types by resolved topic name.
  std::map<std::string, std::string> types() const;

  /// How many messages roscpp keeps for a slow subscriber before it drops the oldest.
  static constexpr std::uint32_t queue_size = 10;
  /// The same for inertial samples: a quarter of a second of them.
  static constexpr std::uint32_t imu_queue_size = 50;

 private:
  using Buffer = boost::shared_array<std::uint8_t>;
  struct Output {
    ros::Publisher publisher;
    std::deque<Buffer> sent;  // buffers that roscpp may still hold
    std::uint32_t queue_size = RosPublishers::queue_size;
  };

  /// Calls `use` with the message that travels on the topic.
  template <typename Use>
  void with_message_of(const OutputTopic& topic, Use use);
  ros::Publisher advertise(ros::NodeHandle& node, const OutputTopic& topic, std::uint32_t length);
  template <typename Message>
  void send(Output& output, const Message& message);
  void send_frame(QueuedFrame& frame, Output& output);
  void send_transforms(ros::Publisher& publisher);
  Output& output_of(const QueuedFrame& frame);
  static std::size_t in_flight(Output& output);

  const std::vector<OutputTopic> topics_;
  const bool with_clock_;
  std::atomic<bool> ready_{false};
  mutable std::mutex mutex_;
  mutable std::atomic<std::size_t> subscribers_{0};
  std::vector<Output> outputs_;  // one per topic
  Output clock_;
  ros::Publisher transforms_publisher_;
  std::vector<StaticTransform> transforms_;
  Stamp transforms_stamp_;
  std::map<std::string, std::string> types_;
  sensor_msgs::LaserScan scan_;
  sensor_msgs::MultiEchoLaserScan echoes_;
  sensor_msgs::PointCloud2 cloud_;
  RosDeviceMessages messages_;
};

}  // namespace lidard
