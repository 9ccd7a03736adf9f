// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/frame_queue.h"

#include <algorithm>

namespace lidard {
namespace {

constexpr std::size_t usual_depth = 2;

QueuedContent what_travels(TopicKind kind) {
  if (kind == TopicKind::message || kind == TopicKind::output_paths) return DeviceMessage();
  return kind == TopicKind::cloud ? QueuedContent(Cloud()) : PlanarScan();
}

}  // namespace

std::size_t queue_depth(const OutputTopic& topic) {
  if (topic.kind == TopicKind::cloud) return usual_depth;
  if (topic.kind != TopicKind::message) return 100;
  return topic.message == message_kind<ImuSample>() ? 50 : usual_depth;
}

FrameQueue::FrameQueue(const std::vector<OutputTopic>& topics, Backpressure backpressure)
    : backpressure_(backpressure) {
  for (const OutputTopic& topic : topics)
    add_lane(what_travels(topic.kind),
             backpressure == Backpressure::block ? usual_depth : queue_depth(topic));
  add_lane(std::vector<StaticTransform>(), usual_depth);
  add_lane(Stamp(), usual_depth);
}

void FrameQueue::add_lane(const QueuedContent& empty, std::size_t depth) {
  const std::size_t number = lanes_.size();
  Lane& lane = lanes_.emplace_back();
  lane.depth = depth;
  // One more than may wait: the thread that publishes holds one.
  lane.frames.assign(depth + 1, {number, 0, {}, empty});
  for (QueuedFrame& frame : lane.frames) lane.free.push_back(&frame);
}

/// For a frame that was released then to find its place.
bool FrameQueue::must_drop(const Lane& lane, Stamp released) {
  constexpr Span longest_wait = std::chrono::seconds(1);
  const std::size_t waiting = lane.waiting.size();
  return waiting >= lane.depth ||
         (waiting >= usual_depth && released - lane.waiting.front()->released > longest_wait);
}

template <typename Fill>
void FrameQueue::push_to(std::size_t number, Stamp released, Fill fill) {
  std::unique_lock lock(mutex_);
  Lane& lane = lanes_.at(number);
  if (backpressure_ == Backpressure::block)
    emptied_.wait(lock, [&] { return stopped_ || lane.waiting.size() < lane.depth; });
  if (stopped_) return;
  while (backpressure_ == Backpressure::drop_oldest && must_drop(lane, released + step_.load())) {
    lane.free.push_back(lane.waiting.front());
    lane.waiting.pop_front();
    ++lane.dropped;
  }
  QueuedFrame* const frame = lane.free.back();
  lane.free.pop_back();
  frame->number = ++pushed_;
  frame->released = released + step_.load();
  lane.watch.released(released);
  fill(frame->content);
  lane.waiting.push_back(frame);
  lock.unlock();
  filled_.notify_one();
}

void FrameQueue::push(const OutputTopic& topic, const PlanarScan& scan, Stamp released) {
  push_to(topic.id, released, [&](QueuedContent& slot) {
    PlanarScan& kept = std::get<PlanarScan>(slot);
    kept = scan;
    kept.stamp = scan.stamp + step_.load();
  });
}

void FrameQueue::push(const OutputTopic& topic, Cloud& cloud, Stamp released) {
  push_to(topic.id, released, [&](QueuedContent& slot) {
    Cloud& kept = std::get<Cloud>(slot);
    kept.frame_id = cloud.frame_id;
    kept.stamp = cloud.stamp + step_.load();
    kept.height = cloud.height;
    kept.points_bytes.swap(cloud.points_bytes);
  });
}

void FrameQueue::push(const OutputTopic& topic, const DeviceMessage& message, Stamp released) {
  push_to(topic.id, released, [&](QueuedContent& slot) {
    DeviceMessage& kept = std::get<DeviceMessage>(slot);
    kept = message;
    std::visit([this](auto& told) { told.stamp = told.stamp + step_.load(); }, kept);
  });
}

void FrameQueue::push(const std::vector<StaticTransform>& transforms, Stamp released) {
  push_to(transforms_lane(), released, [&](QueuedContent& slot) { slot = transforms; });
}

void FrameQueue::push_clock(Stamp now) {
  push_to(clock_lane(), now, [now](QueuedContent& slot) { slot = now; });
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

void FrameQueue::published(QueuedFrame* frame, Stamp now) {
  // A frame on whose way the host's clock was set says nothing about the latency.
  constexpr Span longest_way = std::chrono::minutes(1);
  const Span latency = now - frame->released;
  if (latency >= Span(0) && latency < longest_way) {
    const std::lock_guard lock(mutex_);
    lanes_[frame->lane].watch.published(latency);
  }
  done(frame);
}

TopicFigures FrameQueue::figures(std::size_t topic, Stamp now) const {
  const std::lock_guard lock(mutex_);
  const Lane& lane = lanes_.at(topic);
  TopicFigures figures = lane.watch.figures(now);
  figures.dropped = lane.dropped;
  return figures;
}

void FrameQueue::continue_figures(std::size_t topic, const FrameQueue& before, std::size_t topic_before) {
  const std::scoped_lock lock(mutex_, before.mutex_);
  lanes_.at(topic).watch = before.lanes_.at(topic_before).watch;
  lanes_.at(topic).dropped = before.lanes_.at(topic_before).dropped;
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
