// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/frame_queue.h"

#include <algorithm>

namespace lidard {
namespace {

constexpr std::size_t least_depth = 2;

template <class Kept>
Kept& kept_in(QueuedContent& content) {
  Kept* const kept = std::get_if<Kept>(&content);
  return kept != nullptr ? *kept : content.emplace<Kept>();
}

}  // namespace

std::size_t FrameQueue::add_slot(std::size_t depth) {
  const std::lock_guard lock(mutex_);
  const std::size_t number = slots_.size();
  Slot& slot = slots_.emplace_back();
  slot.depth = backpressure_ == Backpressure::block ? least_depth : depth;
  // One more frame than may wait: the publishing thread holds one.
  slot.frames.assign(slot.depth + 1, {number, 0, {}, {}});
  for (QueuedFrame& frame : slot.frames) slot.free.push_back(&frame);
  return number;
}

void FrameQueue::release(std::size_t number) {
  const std::lock_guard lock(mutex_);
  for (QueuedFrame* const frame : slots_.at(number).free) frame->content = {};
}

/// True if a frame must be dropped to make room.
bool FrameQueue::must_drop(const Slot& slot, Stamp released) {
  constexpr Span longest_wait = std::chrono::seconds(1);
  const std::size_t waiting = slot.waiting.size();
  return waiting >= slot.depth ||
         (waiting >= least_depth && released - slot.waiting.front()->released > longest_wait);
}

void FrameQueue::push(std::size_t number, const Payload& payload, Stamp released) {
  std::unique_lock lock(mutex_);
  Slot& slot = slots_.at(number);
  if (backpressure_ == Backpressure::block)
    emptied_.wait(lock, [&] { return stopped_ || slot.waiting.size() < slot.depth; });
  if (stopped_) return;
  while (backpressure_ == Backpressure::drop_oldest && must_drop(slot, released)) {
    slot.free.push_back(slot.waiting.front());
    slot.waiting.pop_front();
    ++slot.dropped;
  }
  QueuedFrame* const frame = slot.free.back();
  slot.free.pop_back();
  frame->number = ++pushed_;
  frame->released = released;
  slot.watch.released(released);
  fill(payload, frame->content);
  slot.waiting.push_back(frame);
  lock.unlock();
  filled_.notify_one();
}

void FrameQueue::skip(std::size_t number, Stamp released) {
  const std::lock_guard lock(mutex_);
  slots_.at(number).watch.released(released);
}

void FrameQueue::fill(const Payload& payload, QueuedContent& content) {
  const auto keep = [&](auto* given) {
    using Kept = std::remove_const_t<std::remove_pointer_t<decltype(given)>>;
    Kept& kept = kept_in<Kept>(content);
    if constexpr (std::is_same_v<Kept, Cloud> || std::is_same_v<Kept, MergedCloud>) {
      kept.frame_id = given->frame_id;
      kept.stamp = given->stamp;
      kept.height = given->height;
      kept.points_bytes.swap(given->points_bytes);
    } else {
      kept = *given;
    }
  };
  std::visit(keep, payload);
}

FrameQueue::Slot* FrameQueue::oldest() {
  Slot* oldest = nullptr;
  for (Slot& slot : slots_) {
    if (slot.waiting.empty()) continue;
    if (oldest == nullptr || slot.waiting.front()->number < oldest->waiting.front()->number) oldest = &slot;
  }
  return oldest;
}

QueuedFrame* FrameQueue::pop(Span wait) {
  std::unique_lock lock(mutex_);
  Slot* slot = nullptr;
  filled_.wait_for(lock, wait, [&] { return stopped_ || (slot = oldest()) != nullptr; });
  if (stopped_ || slot == nullptr) return nullptr;
  QueuedFrame* frame = slot->waiting.front();
  slot->waiting.pop_front();
  lock.unlock();
  emptied_.notify_all();
  return frame;
}

void FrameQueue::done(QueuedFrame* frame) {
  const std::lock_guard lock(mutex_);
  slots_[frame->slot].free.push_back(frame);
}

void FrameQueue::published(QueuedFrame* frame, Stamp now) {
  // If the host's clock was set and nobody has noticed yet, the frame does not count for the latency.
  constexpr Span longest_way = std::chrono::minutes(1);
  const Span latency = now - frame->released;
  if (latency >= Span(0) && latency < longest_way) {
    const std::lock_guard lock(mutex_);
    slots_[frame->slot].watch.published(latency);
  }
  done(frame);
}

TopicFigures FrameQueue::figures(std::size_t number, Stamp now) const {
  const std::lock_guard lock(mutex_);
  const Slot& slot = slots_.at(number);
  TopicFigures figures = slot.watch.figures(now);
  figures.dropped = slot.dropped;
  return figures;
}

bool FrameQueue::idle() const {
  const std::lock_guard lock(mutex_);
  return std::all_of(slots_.begin(), slots_.end(), [](const Slot& slot) { return slot.idle(); });
}

std::uint64_t FrameQueue::dropped() const {
  const std::lock_guard lock(mutex_);
  std::uint64_t sum = 0;
  for (const Slot& slot : slots_) sum += slot.dropped;
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
