// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <variant>
#include <vector>

#include "daemon/live/topic_watch.h"
#include "daemon/pipeline/sink.h"

namespace lidard {

/// What to do with a frame when the thread that publishes has not yet dealt with those before it.
enum class Backpressure : std::uint8_t {
  drop_oldest,  ///< live: the sensor thread never waits; what was dropped is counted
  block         ///< replay: the calling thread waits; nothing is lost
};

/// Anything that goes out on a topic; a Stamp is the time of a replay.
using QueuedContent = std::variant<PlanarScan, Cloud, DeviceMessage, std::vector<StaticTransform>, Stamp>;

/// A frame on its way from the sensor thread to the one that publishes.
struct QueuedFrame {
  std::size_t lane = 0;  ///< OutputTopic::id, or FrameQueue::transforms_lane(), clock_lane()
  std::uint64_t number = 0;
  Stamp released;
  QueuedContent content;
};

/// How many frames of a topic may wait until they are published. A thread that stood still publishes late
/// what came meanwhile: planar scans of a second (no scanner turns more than 100 times), and inertial samples
/// of a quarter of one. Clouds are large and outdated soon.
std::size_t queue_depth(const OutputTopic& topic);

/// A bounded queue with a lane per topic, see queue_depth(); live, what has waited for a second makes room
/// for what comes. Frames leave in the order they came. Frames and their buffers are recycled: no allocation
/// after warm-up. Knows no middleware.
class FrameQueue {
 public:
  /// `topics` as in output_topics().
  FrameQueue(const std::vector<OutputTopic>& topics, Backpressure backpressure);

  /// By how much the stamps of what is pushed from now on are moved: HostClock::step().
  void set_step(Span step) { step_ = step; }
  void push(const OutputTopic& topic, const PlanarScan& scan, Stamp released);
  /// Swaps points_bytes with a recycled buffer.
  void push(const OutputTopic& topic, Cloud& cloud, Stamp released);
  void push(const OutputTopic& topic, const DeviceMessage& message, Stamp released);
  void push(const std::vector<StaticTransform>& transforms, Stamp released);
  void push_clock(Stamp now);

  /// The oldest frame, or nullptr after `wait` or stop(). Give it back with done().
  QueuedFrame* pop(Span wait);
  void done(QueuedFrame* frame);
  /// The same of a frame that was published, at `now` on the host's clock.
  void published(QueuedFrame* frame, Stamp now);
  /// How a topic does; `now` in the time without steps, as `released` was.
  TopicFigures figures(std::size_t topic, Stamp now) const;
  /// The figures of a topic go on from those of another queue's topic.
  void continue_figures(std::size_t topic, const FrameQueue& before, std::size_t topic_before);
  /// True if every frame pushed was also given back.
  bool idle() const;
  /// Frames dropped so far, of one topic or of all.
  std::uint64_t dropped(std::size_t topic) const { return dropped(topic, topic + 1); }
  std::uint64_t dropped() const { return dropped(0, lanes_.size()); }
  /// Ends all waiting; nothing is taken or given from now on.
  void stop();

  std::size_t transforms_lane() const { return lanes_.size() - 2; }
  std::size_t clock_lane() const { return lanes_.size() - 1; }

 private:
  struct Lane {
    std::vector<QueuedFrame> frames;  // all hold the same kind of thing
    std::deque<QueuedFrame*> waiting;
    std::vector<QueuedFrame*> free;
    std::size_t depth = 0;
    std::uint64_t dropped = 0;
    TopicWatch watch;
  };
  void add_lane(const QueuedContent& empty, std::size_t depth);
  template <typename Fill>
  void push_to(std::size_t lane, Stamp released, Fill fill);
  static bool must_drop(const Lane& lane, Stamp released);
  Lane* oldest();
  std::uint64_t dropped(std::size_t begin, std::size_t end) const;

  Backpressure backpressure_;
  std::atomic<Span> step_{Span(0)};
  mutable std::mutex mutex_;
  std::condition_variable filled_;
  std::condition_variable emptied_;
  std::deque<Lane> lanes_;  // one per topic, then transforms, then clock
  std::uint64_t pushed_ = 0;
  std::size_t out_ = 0;
  bool stopped_ = false;
};

}  // namespace lidard
