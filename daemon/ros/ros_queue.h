// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <string>
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
  enum class What : std::uint8_t { scan, echoes, cloud, fix, time_reference, imu, state, transforms, clock };
  What what = What::scan;
  std::size_t topic = 0;  ///< index into the list of topics; of no meaning for transforms and clock
  std::uint64_t number = 0;
  Stamp released;
  PlanarScan scan;
  Cloud cloud;
  GnssFix fix;
  TimeReference reference;
  ImuSample imu;
  DeviceState state;
  std::vector<StaticTransform> transforms;
};

/// A bounded queue with a lane per topic, of two frames or of 32 inertial samples; frames leave in the order
/// they came. Frames and their buffers are recycled: no allocation after warm-up.
class FrameQueue {
 public:
  FrameQueue(const std::vector<TopicInfo>& topics, Backpressure backpressure);

  /// False if there is no such topic.
  bool push(const std::string& topic, const PlanarScan& scan, Stamp released);
  /// Swaps points_bytes with a recycled buffer.
  bool push(const std::string& topic, Cloud& cloud, Stamp released);
  bool push(const std::string& topic, const GnssFix& fix, Stamp released);
  bool push(const std::string& topic, const TimeReference& reference, Stamp released);
  bool push(const std::string& topic, const ImuSample& sample, Stamp released);
  bool push(const std::string& topic, const DeviceState& state, Stamp released);
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
    QueuedFrame::What what;
    std::size_t depth;
    std::deque<QueuedFrame*> waiting;
    std::vector<QueuedFrame*> free;
    std::uint64_t dropped = 0;
  };
  void add_lane(QueuedFrame::What what);
  Lane* find(const std::string& topic);
  template <typename Fill>
  void push_to(Lane& lane, Fill fill);
  template <typename Item>
  bool push_item(const std::string& topic, QueuedFrame::What what, Item QueuedFrame::*place, const Item& item,
                 Stamp released);
  Lane* oldest();

  Backpressure backpressure_;
  mutable std::mutex mutex_;
  std::condition_variable filled_;
  std::condition_variable emptied_;
  std::map<std::string, std::size_t> lanes_by_topic_;
  std::deque<Lane> lanes_;  // one per topic, then transforms, then clock
  std::deque<QueuedFrame> frames_;
  std::uint64_t pushed_ = 0;
  std::size_t out_ = 0;
  bool stopped_ = false;
};

}  // namespace lidard
