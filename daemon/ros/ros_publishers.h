// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/publisher.h>

#include <atomic>
#include <boost/shared_array.hpp>
#include <deque>
#include <mutex>
#include <string>
#include <vector>

#include "daemon/live/frame_queue.h"
#include "daemon/ros/ros_message.h"

namespace ros {
class NodeHandle;
}

namespace lidard {

/// The publishers of all output topics, in the order of FrameQueue's lanes. The master thread advertises, the
/// ROS thread publishes.
class RosPublishers {
 public:
  RosPublishers(const std::vector<OutputTopic>& topics, bool clock);

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
  /// Messages of all topics that some subscriber's socket has not yet taken.
  std::size_t in_flight();
  /// Subscribers of all frame topics together; the last known number while a frame is being published.
  std::size_t subscribers() const;

 private:
  struct Output {
    std::string topic;
    RosMessage message;
    ros::Publisher publisher = {};
    std::deque<boost::shared_array<std::uint8_t>> sent = {};  // buffers that roscpp may still hold
    std::uint32_t queue_size() const;
    std::size_t in_flight();
    void send();
    ros::Publisher advertise(ros::NodeHandle& node) const;
  };
  Output& transforms() { return outputs_[frames_]; }

  const std::size_t frames_;  // topics of frames
  const bool with_clock_;
  std::atomic<bool> ready_{false};
  mutable std::mutex mutex_;
  mutable std::atomic<std::size_t> subscribers_{0};
  std::vector<Output> outputs_;  // one per topic of frames, then /tf_static, then /clock
};

}  // namespace lidard
