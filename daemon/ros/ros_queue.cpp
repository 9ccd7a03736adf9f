// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/ros_queue.h"

namespace lidard {
namespace {

constexpr std::size_t usual_depth = 2;

QueuedFrame::What what_travels(TopicKind kind) {
  switch (kind) {
    case TopicKind::scan:
      return QueuedFrame::What::scan;
    case TopicKind::echoes:
      return QueuedFrame::What::echoes;
    case TopicKind::cloud:
      return QueuedFrame::What::cloud;
    case TopicKind::message:
      return QueuedFrame::What::message;
  }
  return QueuedFrame::What::scan;
}

/// How many frames may wait. Inertial samples come every 5 ms, and a large cloud takes longer to publish.
std::size_t depth_of(const OutputTopic& topic) {
  return topic.kind == TopicKind::message && topic.message == message_kind<ImuSample>() ? 32 : usual_depth;
}

}  // namespace

FrameQueue::FrameQueue(const std::vector<OutputTopic>& topics, Backpressure backpressure)
    : backpressure_(backpressure) {
  for (const OutputTopic& topic : topics) add_lane(what_travels(topic.kind), depth_of(topic));
  add_lane(QueuedFrame::What::transforms, usual_depth);
  add_lane(QueuedFrame::What::clock, usual_depth);
}

void FrameQueue::add_lane(QueuedFrame::What what, std::size_t depth) {
  Lane lane{depth, {}, {}, 0};
  // One more than may wait: the ROS thread holds one.
  for (std::size_t i = 0; i < lane.depth + 1; ++i) {
    frames_.emplace_back();
    frames_.back().what = what;
    frames_.back().topic = lanes_.size();
    lane.free.push_back(&frames_.back());
  }
  lanes_.push_back(std::move(lane));
}

template <typename Fill>
void FrameQueue::push_to(Lane& lane, Fill fill) {
  std::unique_lock lock(mutex_);
  if (backpressure_ == Backpressure::block)
    emptied_.wait(lock, [&] { return stopped_ || lane.waiting.size() < lane.depth; });
  if (stopped_) return;
  QueuedFrame* frame = nullptr;
  if (lane.waiting.size() < lane.depth) {
    frame = lane.free.back();
    lane.free.pop_back();
  } else {
    frame = lane.waiting.front();
    lane.waiting.pop_front();
    ++lane.dropped;
  }
  frame->number = ++pushed_;
  fill(*frame);
  lane.waiting.push_back(frame);
  lock.unlock();
  filled_.notify_one();
}

void FrameQueue::push(const OutputTopic& topic, const PlanarScan& scan, Stamp released) {
  push_to(lanes_.at(topic.id), [&](QueuedFrame& frame) {
    frame.scan = scan;
    frame.released = released;
  });
}

void FrameQueue::push(const OutputTopic& topic, Cloud& cloud, Stamp released) {
  push_to(lanes_.at(topic.id), [&](QueuedFrame& frame) {
    frame.cloud.frame_id = cloud.frame_id;
    frame.cloud.stamp = cloud.stamp;
    frame.cloud.format = cloud.format;
    frame.cloud.points_bytes.swap(cloud.points_bytes);
    frame.released = released;
  });
}

void FrameQueue::push(const OutputTopic& topic, const DeviceMessage& message, Stamp released) {
  push_to(lanes_.at(topic.id), [&](QueuedFrame& frame) {
    frame.message = message;
    frame.released = released;
  });
}

void FrameQueue::push(const std::vector<StaticTransform>& transforms, Stamp released) {
  push_to(lanes_[lanes_.size() - 2], [&](QueuedFrame& frame) {
    frame.transforms = transforms;
    frame.released = released;
  });
}

void FrameQueue::push_clock(Stamp now) {
  push_to(lanes_.back(), [&](QueuedFrame& frame) { frame.released = now; });
}

FrameQueue::Lane* FrameQueue::oldest() {
  Lane* oldest = nullptr;
  for (auto& lane : lanes_) {
    if (lane.waiting.empty()) continue;
    if (oldest == nullptr || lane.waiting.front()->number < oldest->waiting.front()->number) oldest = &lane;
  }
  return oldest;
}

QueuedFrame* FrameQueue::pop(Span wait) {
  std::unique_lock lock(mutex_);
  Lane* lane = nullptr;
  filled_.wait_for(lock, wait, [&] { return stopped_ || (lane = oldest()) != nullptr; });
  if (stopped_ || lane == nullptr) return nullptr;
  QueuedFrame* frame = lane->waiting.front();
  lane->waiting.pop_front();
  ++out_;
  lock.unlock();
  emptied_.notify_all();
  return frame;
}

void FrameQueue::done(QueuedFrame* frame) {
  const std::lock_guard lock(mutex_);
  lanes_[frame->topic].free.push_back(frame);
  --out_;
}

bool FrameQueue::idle() const {
  const std::lock_guard lock(mutex_);
  for (const auto& lane : lanes_) {
    if (!lane.waiting.empty()) return false;
  }
  return out_ == 0;
}

std::uint64_t FrameQueue::dropped(std::size_t topic) const {
  const std::lock_guard lock(mutex_);
  return lanes_[topic].dropped;
}

std::uint64_t FrameQueue::dropped() const {
  const std::lock_guard lock(mutex_);
  std::uint64_t sum = 0;
  for (const auto& lane : lanes_) sum += lane.dropped;
  return sum;
}

void FrameQueue::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
  }
  filled_.notify_all();
  emptied_.notify_all();
}

}  // namespace lidard
