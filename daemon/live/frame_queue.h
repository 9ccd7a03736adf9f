// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <variant>
#include <vector>

#include "daemon/live/topic_watch.h"
#include "daemon/pipeline/sink.h"

namespace lidard {

/// How to handle a frame while earlier frames are still queued for the publishing thread.
enum class Backpressure : std::uint8_t {
  drop_oldest,  ///< live: the sensor thread never waits; dropped frames are counted
  block         ///< replay: the calling thread waits; no frame is lost
};

/// Anything that goes out on a topic; a Stamp is the time of a replay.
using QueuedContent =
    std::variant<PlanarScan, Cloud, MergedCloud, DeviceMessage, std::vector<StaticTransform>, Stamp>;

/// A frame queued for the publishing thread.
struct QueuedFrame {
  std::size_t slot = 0;
  std::uint64_t number = 0;
  Stamp released;
  QueuedContent content;
  Payload payload() {
    return std::visit([](auto& held) { return Payload(held); }, content);
  }
};

/// A bounded queue with a slot per topic; live, what has waited for a second makes room for what comes.
/// Frames leave in the order they came. Frames and their buffers are recycled: no allocation after warm-up.
/// Knows no middleware.
class FrameQueue {
 public:
  explicit FrameQueue(Backpressure backpressure) : backpressure_(backpressure) {}

  /// Adds a slot, for frames of one type, and returns its number. `depth`: how many frames may wait (2 with
  /// Backpressure::block).
  std::size_t add_slot(std::size_t depth);
  /// Frees the memory of a slot that is not used for now.
  void release(std::size_t slot);

  /// Swaps the points_bytes of a cloud with a recycled buffer.
  void push(std::size_t slot, const Payload& payload, Stamp released);
  /// Counts a frame that was not made, since it has no consumer.
  void skip(std::size_t slot, Stamp released);

  /// The oldest frame, or nullptr after `wait` or stop(). Give it back with done().
  QueuedFrame* pop(Span wait);
  void done(QueuedFrame* frame);
  /// The same of a frame that was published at `now`.
  void published(QueuedFrame* frame, Stamp now);
  /// The figures of a slot's topic.
  TopicFigures figures(std::size_t slot, Stamp now) const;
  /// True if all frames were given back.
  bool idle() const;
  /// Frames dropped so far.
  std::uint64_t dropped() const;
  /// Ends all waiting; from now on nothing is pushed or popped.
  void stop();

 private:
  struct Slot {
    std::vector<QueuedFrame> frames;  // all hold the same kind of thing
    std::deque<QueuedFrame*> waiting;
    std::vector<QueuedFrame*> free;
    std::size_t depth = 0;
    std::uint64_t dropped = 0;
    TopicWatch watch;
    bool idle() const { return free.size() == frames.size(); }
  };
  static bool must_drop(const Slot& slot, Stamp released);
  static void fill(const Payload& payload, QueuedContent& content);
  Slot* oldest();

  Backpressure backpressure_;
  mutable std::mutex mutex_;
  std::condition_variable filled_;
  std::condition_variable emptied_;
  std::deque<Slot> slots_;
  std::uint64_t pushed_ = 0;
  bool stopped_ = false;
};

}  // namespace lidard
