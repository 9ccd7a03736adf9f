// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/frame_queue.h"

#include <algorithm>

namespace lidard {
namespace {

QueuedContent what_travels(TopicKind kind) {
  switch (kind) {
    case TopicKind::scan:
    case TopicKind::echoes:
      return PlanarScan();
    case TopicKind::cloud:
      return Cloud();
    case TopicKind::fix:
      return GnssFix();
    case TopicKind::time_reference:
      return TimeReference();
    case TopicKind::imu:
      return ImuSample();
    case TopicKind::state:
      return DeviceState();
  }
  return {};
}

/// How many frames may wait. Inertial samples come every 5 ms, and a large cloud takes longer to publish.
std::size_t depth_of(const QueuedContent& what) { return std::holds_alternative<ImuSample>(what) ? 32 : 2; }

}  // namespace

FrameQueue::FrameQueue(const std::vector<TopicInfo>& topics, Backpressure backpressure)
    : backpressure_(backpressure) {
  for (const auto& topic : topics) {
    lanes_by_topic_[topic.name] = lanes_.size();
    add_lane(what_travels(topic.kind));
  }
  add_lane(std::vector<StaticTransform>());
  add_lane(Stamp());
}

void FrameQueue::add_lane(const QueuedContent& empty) {
  const std::size_t number = lanes_.size();
  Lane& lane = lanes_.emplace_back();
  lane.depth = depth_of(empty);
  // One more than may wait: the thread that publishes holds one.
  lane.frames.assign(lane.depth + 1, {number, 0, {}, empty});
  for (QueuedFrame& frame : lane.frames) lane.free.push_back(&frame);
}

FrameQueue::Lane* FrameQueue::find(const std::string& topic) {
  const auto found = lanes_by_topic_.find(topic);
  return found == lanes_by_topic_.end() ? nullptr : &lanes_[found->second];
}

/// The frame to fill; nullptr after stop().
QueuedFrame* FrameQueue::begin_push(Lane& lane, std::unique_lock<std::mutex>& lock) {
  if (backpressure_ == Backpressure::block)
    emptied_.wait(lock, [&] { return stopped_ || lane.waiting.size() < lane.depth; });
  if (stopped_) return nullptr;
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
  return frame;
}

bool FrameQueue::push(const std::string& topic, Cloud& cloud, Stamp released) {
  return push_with<Cloud>(find(topic), released, [&cloud](Cloud& slot) {
    slot.frame_id = cloud.frame_id;
    slot.stamp = cloud.stamp;
    slot.format = cloud.format;
    slot.points_bytes.swap(cloud.points_bytes);
  });
}

void FrameQueue::push(const std::vector<StaticTransform>& transforms, Stamp released) {
  using Transforms = std::vector<StaticTransform>;
  push_with<Transforms>(&lanes_[transforms_lane()], released, [&](Transforms& slot) { slot = transforms; });
}

void FrameQueue::push_clock(Stamp now) {
  push_with<Stamp>(&lanes_[clock_lane()], now, [now](Stamp& slot) { slot = now; });
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
  lanes_[frame->lane].free.push_back(frame);
  --out_;
}

bool FrameQueue::idle() const {
  const std::lock_guard lock(mutex_);
  const bool empty =
      std::all_of(lanes_.begin(), lanes_.end(), [](const Lane& lane) { return lane.waiting.empty(); });
  return empty && out_ == 0;
}

std::uint64_t FrameQueue::dropped(std::size_t begin, std::size_t end) const {
  const std::lock_guard lock(mutex_);
  std::uint64_t sum = 0;
  for (std::size_t i = begin; i < end; ++i) sum += lanes_[i].dropped;
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
