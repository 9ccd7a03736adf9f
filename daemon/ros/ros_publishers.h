// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <ros/topic_manager.h>

#include <algorithm>
#include <atomic>
#include <boost/shared_array.hpp>
#include <chrono>
#include <deque>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "daemon/live/frame_queue.h"
#include "daemon/ros/ros_callback_thread.h"
#include "daemon/ros/ros_message.h"

namespace lidard {

/// The publishers of all output topics, in the order of FrameQueue's lanes. The master thread advertises, the
/// ROS thread publishes.
class RosPublishers {
 public:
  RosPublishers(const std::vector<OutputTopic>& topics, bool clock)
      : frames_(topics.size()), with_clock_(clock), losses_(topics.size()) {
    for (const OutputTopic& topic : topics)
      outputs_.push_back({topic.name, message_for(topic), std::max(least_queue, queue_depth(topic))});
    outputs_.push_back({"/tf_static", tf2_msgs::TFMessage(), least_queue});
    outputs_.push_back({"/clock", rosgraph_msgs::Clock(), least_queue});
  }

  /// Advertises everything; ROS must run. Called by the master thread, may wait for the master.
  void advertise() {
    ros::NodeHandle node;
    std::vector<ros::Publisher> publishers;
    for (const Output& output : outputs_)
      publishers.push_back(output.topic != "/clock" || with_clock_ ? output.advertise(node)
                                                                   : ros::Publisher());

    const std::lock_guard lock(mutex_);
    for (std::size_t i = 0; i < outputs_.size(); ++i) outputs_[i].publisher = publishers[i];
    if (!std::get<tf2_msgs::TFMessage>(transforms().message).transforms.empty()) transforms().send();
    ready_ = true;
  }
  /// Takes over what is advertised already on topics of the same name and type: their subscribers stay.
  /// Called by the master thread, does not wait for the master.
  void adopt(RosPublishers& before) {
    const std::scoped_lock lock(mutex_, before.mutex_);
    for (Output& output : outputs_) {
      for (const Output& known : before.outputs_) {
        if (known.topic != output.topic || known.message.index() != output.message.index()) continue;
        output.publisher = known.publisher;
      }
    }
    ready_ = before.ready_.load();
  }
  /// Advertises what is not advertised. Called like advertise().
  void advertise_missing() {
    ros::NodeHandle node;
    for (Output& output : outputs_) {
      if (!ready_ || output.publisher || (output.topic == "/clock" && !with_clock_)) continue;
      const ros::Publisher publisher = output.advertise(node);
      const std::lock_guard lock(mutex_);
      output.publisher = publisher;
    }
  }
  /// Withdraws topics and advertises them anew, so that subscribers see a new publisher. Called like
  /// advertise(); frames of these topics are lost meanwhile.
  void advertise_again(const std::vector<std::string>& topics) {
    ros::NodeHandle node;
    for (Output& output : outputs_) {
      if (!ready_ || std::find(topics.begin(), topics.end(), output.topic) == topics.end()) continue;
      ros::Publisher publisher;
      {
        const std::lock_guard lock(mutex_);
        std::swap(publisher, output.publisher);
      }
      publisher.shutdown();
      publisher = output.advertise(node);
      const std::lock_guard lock(mutex_);
      output.publisher = publisher;
    }
  }
  /// Withdraws everything. With `leave` nothing is told to roscpp, whose destructors wait for the master.
  void drop(bool leave) {
    std::vector<ros::Publisher> publishers;
    {
      const std::lock_guard lock(mutex_);
      ready_ = false;
      for (Output& output : outputs_) publishers.push_back(std::exchange(output.publisher, {}));
      for (Output& output : outputs_) output.sent.clear();
    }
    if (leave) leave_behind(std::move(publishers));
  }
  bool ready() const { return ready_; }

  /// Converts and publishes; false if nothing is advertised. Fixed transforms are kept for later then.
  bool publish(QueuedFrame& frame) {
    const std::lock_guard lock(mutex_);
    Output& output = outputs_[frame.lane];
    const bool can_send = ready_ && ros::ok() && output.publisher;
    if (const auto* fixed = std::get_if<std::vector<StaticTransform>>(&frame.content)) {
      to_ros(*fixed, frame.released, std::get<tf2_msgs::TFMessage>(output.message));
    } else if (!can_send ||
               !std::visit([&](auto& content) { return convert(content, output.message); }, frame.content)) {
      return false;
    }
    if (can_send) output.send();
    if (frame.lane < frames_) losses_[frame.lane].note(output.lost);
    give_back(output.message, frame.content);
    return true;
  }
  /// Messages of the frame's topic that some subscriber's socket has not yet taken.
  std::size_t in_flight(const QueuedFrame& frame) {
    const std::lock_guard lock(mutex_);
    return outputs_[frame.lane].in_flight();
  }
  /// Messages of all topics that some subscriber's socket has not yet taken.
  std::size_t in_flight() {
    const std::lock_guard lock(mutex_);
    std::size_t sum = 0;
    for (auto& output : outputs_) sum += output.in_flight();
    return sum;
  }
  /// Counts the subscribers of all frame topics together. May hang in roscpp: for the thread that publishes.
  void count_subscribers() {
    const std::lock_guard lock(mutex_);
    std::size_t sum = 0;
    for (std::size_t i = 0; i < frames_; ++i) sum += outputs_[i].publisher.getNumSubscribers();
    subscribers_ = sum;
  }
  /// As they were counted last. Any thread may ask, and is not held up.
  std::size_t subscribers() const { return subscribers_; }
  /// Messages of a topic that slow subscribers have not got, and whether within the last 10 s. Any thread may
  /// ask.
  std::uint64_t lost(std::size_t topic) const { return losses_[topic].count; }
  bool loses(std::size_t topic) const { return losses_[topic].is_news(); }

 private:
  /// Messages that roscpp is sending to slow subscribers beside those in its queues.
  static constexpr std::size_t most_being_sent = 8;
  static constexpr std::size_t least_queue = 10;
  /// What subscribers of a topic have not got.
  struct Losses {
    using Clock = std::chrono::steady_clock;
    std::atomic<std::uint64_t> count{0};
    std::atomic<Clock::time_point> newest{Clock::time_point()};
    void note(std::uint64_t now) {
      if (count.exchange(now) != now) newest = Clock::now();
    }
    bool is_news() const { return count > 0 && Clock::now() - newest.load() < std::chrono::seconds(10); }
  };
  struct Output {
    std::string topic;
    RosMessage message;
    std::size_t queue_size;  // messages that roscpp keeps for a slow subscriber before it drops the oldest
    ros::Publisher publisher = {};
    std::deque<boost::shared_array<std::uint8_t>> sent = {};  // buffers that roscpp may still hold
    std::uint64_t lost = 0;                                   // messages that a subscriber has not got
    std::size_t in_flight() {
      count_lost();
      while (!sent.empty() && sent.front().use_count() == 1) sent.pop_front();
      return sent.size();
    }
    /// roscpp lets go of a message before an older one only when it drops it, since the queue for a slow
    /// subscriber is full. Whether the oldest is still held is looked at last.
    void count_lost() {
      const auto is_free = [](const auto& buffer) { return buffer.use_count() == 1; };
      if (sent.size() < 2 || std::none_of(sent.begin() + 1, sent.end(), is_free) || is_free(sent.front()))
        return;
      const auto kept = std::remove_if(sent.begin() + 1, sent.end(), is_free);
      lost += static_cast<std::uint64_t>(sent.end() - kept);
      sent.erase(kept, sent.end());
    }
    void send() {
      std::visit(
          [this](const auto& held) {
            if (publisher.isLatched()) return publisher.publish(held);
            // ros::Publisher::publish() does just this, but hides the buffer, which tells when all sockets
            // have taken it.
            ros::SerializedMessage serialized;
            ros::TopicManager::instance()->publish(
                publisher.getTopic(), [&held] { return ros::serialization::serializeMessage(held); },
                serialized);
            // What all sockets have taken is to be freed: a cloud takes 10 MB.
            in_flight();
            if (serialized.buf) sent.push_back(serialized.buf);
            while (sent.size() > queue_size + most_being_sent) sent.pop_front();
          },
          message);
    }
    ros::Publisher advertise(ros::NodeHandle& node) const {
      return std::visit(
          [&](const auto& held) {
            using Message = std::decay_t<decltype(held)>;
            return node.advertise<Message>(topic, static_cast<std::uint32_t>(queue_size),
                                           std::is_same_v<Message, tf2_msgs::TFMessage>);
          },
          message);
    }
  };
  /// The memory of a cloud's points is used for the next cloud, not for the next message: a large one fewer.
  static void give_back(RosMessage& message, QueuedContent& content) {
    auto* const sent = std::get_if<sensor_msgs::PointCloud2>(&message);
    auto* const cloud = std::get_if<Cloud>(&content);
    if (sent != nullptr && cloud != nullptr) sent->data.swap(cloud->points_bytes);
  }
  Output& transforms() { return outputs_[frames_]; }

  const std::size_t frames_;  // topics of frames
  const bool with_clock_;
  std::atomic<bool> ready_{false};
  std::mutex mutex_;
  std::atomic<std::size_t> subscribers_{0};
  std::vector<Losses> losses_;   // by topic of frames
  std::vector<Output> outputs_;  // one per topic of frames, then /tf_static, then /clock
};

}  // namespace lidard
