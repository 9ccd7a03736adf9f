// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/ros_publishers.h"

#include <ros/topic_manager.h>
#include <rosgraph_msgs/Clock.h>
#include <rosgraph_msgs/Log.h>

#include <algorithm>
#include <utility>

namespace lidard {

RosPublishers::RosPublishers(std::vector<OutputTopic> topics, bool clock)
    : topics_(std::move(topics)), with_clock_(clock) {}

template <typename Use>
void RosPublishers::with_message_of(const OutputTopic& topic, Use use) {
  switch (topic.kind) {
    case TopicKind::scan:
      return use(scan_);
    case TopicKind::echoes:
      return use(echoes_);
    case TopicKind::cloud:
      return use(cloud_);
    case TopicKind::message:
      return messages_.with_kind(topic.message, use);
  }
}

ros::Publisher RosPublishers::advertise(ros::NodeHandle& node, const OutputTopic& topic,
                                        std::uint32_t length) {
  ros::Publisher publisher;
  with_message_of(topic, [&](const auto& message) {
    publisher = node.advertise<std::decay_t<decltype(message)>>(topic.name, length);
  });
  return publisher;
}

void RosPublishers::advertise() {
  ros::NodeHandle node;
  std::vector<Output> outputs(topics_.size());
  std::map<std::string, std::string> types;
  for (std::size_t i = 0; i < topics_.size(); ++i) {
    const bool imu = topics_[i].kind == TopicKind::message && topics_[i].message == message_kind<ImuSample>();
    if (imu) outputs[i].queue_size = imu_queue_size;
    outputs[i].publisher = advertise(node, topics_[i], outputs[i].queue_size);
    with_message_of(topics_[i], [&](const auto& message) {
      types[outputs[i].publisher.getTopic()] = ros::message_traits::datatype(message);
    });
  }
  auto transforms = node.advertise<tf2_msgs::TFMessage>("/tf_static", queue_size, true);
  Output clock;
  if (with_clock_) clock.publisher = node.advertise<rosgraph_msgs::Clock>("/clock", queue_size);
  types["/tf_static"] = ros::message_traits::datatype<tf2_msgs::TFMessage>();
  types["/clock"] = ros::message_traits::datatype<rosgraph_msgs::Clock>();
  types["/rosout"] = ros::message_traits::datatype<rosgraph_msgs::Log>();
  types["/diagnostics"] = ros::message_traits::datatype<diagnostic_msgs::DiagnosticArray>();

  const std::lock_guard lock(mutex_);
  outputs_ = std::move(outputs);
  clock_ = std::move(clock);
  transforms_publisher_ = std::move(transforms);
  types_ = std::move(types);
  if (!transforms_.empty()) send_transforms(transforms_publisher_);
  ready_ = true;
}

void RosPublishers::advertise_again(const std::vector<std::string>& topics) {
  ros::NodeHandle node;
  for (std::size_t i = 0; i < topics_.size(); ++i) {
    if (!ready_ || std::find(topics.begin(), topics.end(), topics_[i].name) == topics.end()) continue;
    Output output;
    {
      const std::lock_guard lock(mutex_);
      std::swap(output, outputs_[i]);
    }
    output.publisher.shutdown();
    output.publisher = advertise(node, topics_[i], output.queue_size);
    const std::lock_guard lock(mutex_);
    outputs_[i] = std::move(output);
  }
}

void RosPublishers::drop(bool leave) {
  std::vector<Output> outputs;
  Output clock;
  ros::Publisher transforms;
  {
    const std::lock_guard lock(mutex_);
    ready_ = false;
    outputs.swap(outputs_);
    std::swap(clock, clock_);
    std::swap(transforms, transforms_publisher_);
  }
  if (!leave) return;
  // Reachable for ever, so that no destructor runs.
  static auto* const left = new std::deque<ros::Publisher>;
  for (const auto& output : outputs) left->push_back(output.publisher);
  left->push_back(clock.publisher);
  left->push_back(transforms);
}

template <typename Message>
void RosPublishers::send(Output& output, const Message& message) {
  // ros::Publisher::publish() does just this, but hides the buffer, which tells when all sockets have taken
  // it.
  ros::SerializedMessage serialized;
  ros::TopicManager::instance()->publish(
      output.publisher.getTopic(), [&message] { return ros::serialization::serializeMessage(message); },
      serialized);
  if (serialized.buf) output.sent.push_back(serialized.buf);
  while (output.sent.size() > output.queue_size) output.sent.pop_front();
}

void RosPublishers::send_transforms(ros::Publisher& publisher) {
  tf2_msgs::TFMessage message;
  to_ros(transforms_, transforms_stamp_, message);
  publisher.publish(message);
}

void RosPublishers::send_frame(QueuedFrame& frame, Output& output) {
  switch (frame.what) {
    case QueuedFrame::What::scan:
      to_ros(frame.scan, scan_);
      send(output, scan_);
      break;
    case QueuedFrame::What::echoes:
      to_ros(frame.scan, echoes_);
      send(output, echoes_);
      break;
    case QueuedFrame::What::cloud:
      to_ros(frame.cloud, cloud_);
      send(output, cloud_);
      cloud_.data.swap(frame.cloud.points_bytes);
      break;
    case QueuedFrame::What::message:
      messages_.convert(frame.message, [&](const auto& message) { send(output, message); });
      break;
    case QueuedFrame::What::clock: {
      rosgraph_msgs::Clock message;
      message.clock = to_ros(frame.released);
      send(output, message);
      break;
    }
    case QueuedFrame::What::transforms:
      break;
  }
}

RosPublishers::Output& RosPublishers::output_of(const QueuedFrame& frame) {
  return frame.what == QueuedFrame::What::clock ? clock_ : outputs_[frame.topic];
}

bool RosPublishers::publish(QueuedFrame& frame) {
  const std::lock_guard lock(mutex_);
  if (frame.what == QueuedFrame::What::transforms) {
    transforms_ = frame.transforms;
    transforms_stamp_ = frame.released;
    if (ready_) send_transforms(transforms_publisher_);
    return true;
  }
  if (!ready_ || !ros::ok()) return false;
  Output& output = output_of(frame);
  if (!output.publisher) return false;
  send_frame(frame, output);
  return true;
}

std::size_t RosPublishers::in_flight(Output& output) {
  while (!output.sent.empty() && output.sent.front().use_count() == 1) output.sent.pop_front();
  return output.sent.size();
}

std::size_t RosPublishers::in_flight(const QueuedFrame& frame) {
  const std::lock_guard lock(mutex_);
  if (!ready_ || frame.what == QueuedFrame::What::transforms) return 0;
  return in_flight(output_of(frame));
}

std::size_t RosPublishers::in_flight() {
  const std::lock_guard lock(mutex_);
  std::size_t sum = in_flight(clock_);
  for (auto& output : outputs_) sum += in_flight(output);
  return sum;
}

std::size_t RosPublishers::subscribers() const {
  // Not to be held up by a ROS thread that hangs: its state is to be told.
  const std::unique_lock lock(mutex_, std::try_to_lock);
  if (!lock.owns_lock()) return subscribers_;
  std::size_t sum = 0;
  for (const auto& output : outputs_) sum += output.publisher.getNumSubscribers();
  subscribers_ = sum;
  return sum;
}

std::map<std::string, std::string> RosPublishers::types() const {
  const std::lock_guard lock(mutex_);
  return types_;
}

}  // namespace lidard
