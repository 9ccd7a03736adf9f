// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <vector>

#include "daemon/pipeline/sink.h"

namespace lidard {

/// What to do with a frame when the ROS thread has not yet dealt with those before it.
enum class Backpressure : std::uint8_t {
  drop_oldest,  ///< live: the sensor thread never waits; what was dropped is counted
  block         ///< replay: the calling thread waits; nothing is lost
};

/// A frame on its way from the sensor thread to the ROS thread.
struct QueuedFrame {
  enum class What : std::uint8_t { scan, echoes, cloud, message, transforms, clock };
  What what = What::scan;
  std::size_t topic = 0;  ///< OutputTopic::id; of no meaning for transforms and clock
  std::uint64_t number = 0;
  Stamp released;
  PlanarScan scan;
  Cloud cloud;
  DeviceMessage message;
  std::vector<StaticTransform> transforms;
};

/// A bounded queue with a lane per topic, of two frames or of 32 inertial samples; frames leave in the order
/// they came. Frames and their buffers are recycled: no allocation after warm-up.
class FrameQueue {
 public:
  /// `topics` as in output_topics().
  FrameQueue(const std::vector<OutputTopic>& topics, Backpressure backpressure);

  void push(const OutputTopic& topic, const PlanarScan& scan, Stamp released);
  /// Swaps points_bytes with a recycled buffer.
  void push(const OutputTopic& topic, Cloud& cloud, Stamp released);
  void push(const OutputTopic& topic, const DeviceMessage& message, Stamp released);
  void push(const std::vector<StaticTransform>& transforms, Stamp released);
  void push_clock(Stamp now);

  /// The oldest frame, or nullptr after `wait` or stop(). Give it back with done().
  QueuedFrame* pop(Span wait);
  void done(QueuedFrame* frame);
  /// True if every frame pushed was also given back.
  bool idle() const;
  /// Frames dropped so far, of one topic or of all.
  std::uint64_t dropped(std::size_t topic) const;
  std::uint64_t dropped() const;
  /// Ends all waiting; nothing is taken or given from now on.
  void stop();

 private:
  struct Lane {
    std::size_t depth;
    std::deque<QueuedFrame*> waiting;
    std::vector<QueuedFrame*> free;
    std::uint64_t dropped = 0;
  };
  void add_lane(QueuedFrame::What what, std::size_t depth);
  template <typename Fill>
  void push_to(Lane& lane, Fill fill);
  Lane* oldest();

  Backpressure backpressure_;
  mutable std::mutex mutex_;
  std::condition_variable filled_;
  std::condition_variable emptied_;
  std::deque<Lane> lanes_;  // one per topic, then transforms, then clock
  std::deque<QueuedFrame> frames_;
  std::uint64_t pushed_ = 0;
  std::size_t out_ = 0;
  bool stopped_ = false;
};

}  // namespace lidard
