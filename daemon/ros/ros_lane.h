// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <thread>
#include <vector>

#include "daemon/live/frame_queue.h"
#include "daemon/pipeline/sink.h"
#include "daemon/ros/ros_environment.h"
#include "daemon/ros/ros_publishers.h"
#include "daemon/ros/ros_pulse.h"

namespace lidard {

/// What one lane of the pipeline produces, on its way to ROS: a queue, and a thread that converts and
/// publishes. The calls of FrameSink never wait (unless Backpressure::block).
class RosLane final : public FrameSink {
 public:
  using TakeDiagnostics = std::function<void(const std::vector<DiagnosticItem>&)>;

  /// `pulse` must outlive this; `thread`: which of its threads this one is.
  RosLane(const RosOptions& options, const std::vector<OutputTopic>& topics, RosPulse& pulse,
          RosPulse::Thread thread, TakeDiagnostics diagnostics);
  ~RosLane() override { stop(); }

  /// Goes on where another one of the same lane is: with the topics that are the same.
  void continue_after(RosLane& before);
  void start();
  /// Publishes nothing any more.
  void stop();
  /// Publishes what waits, then stops.
  void finish();

  void scan(const OutputTopic& topic, const PlanarScan& scan, Stamp released) override {
    queue_.push(topic, scan, released);
  }
  void cloud(const OutputTopic& topic, Cloud& cloud, Stamp released) override {
    queue_.push(topic, cloud, released);
  }
  void message(const OutputTopic& topic, const DeviceMessage& message, Stamp released) override {
    queue_.push(topic, message, released);
  }
  void transforms(const std::vector<StaticTransform>& transforms, Stamp released) override {
    queue_.push(transforms, released);
  }
  void diagnostics(const std::vector<DiagnosticItem>& items, Stamp) override { diagnostics_(items); }

  FrameQueue& queue() { return queue_; }
  const FrameQueue& queue() const { return queue_; }
  /// How a topic does; `now` as FrameQueue::figures().
  TopicFigures figures(std::size_t topic, Stamp now) const;
  /// An item for each topic that something came out on.
  void add_diagnostics(std::vector<DiagnosticItem>& items, Stamp now) const;
  RosPublishers& publishers() { return publishers_; }
  const RosPublishers& publishers() const { return publishers_; }
  /// What has not reached the sockets of all subscribers.
  std::size_t in_flight() { return (queue_.idle() ? 0 : 1) + publishers_.in_flight(); }
  std::uint64_t published() const { return published_; }
  std::uint64_t without_ros() const { return without_ros_; }

 private:
  void run();
  bool deal_with(QueuedFrame& frame);
  void wait_for_subscribers_of(const QueuedFrame& frame);

  const bool block_;
  const std::vector<OutputTopic> topics_;
  FrameQueue queue_;
  RosPublishers publishers_;
  RosPulse& pulse_;
  const RosPulse::Thread number_;
  const TakeDiagnostics diagnostics_;
  std::atomic<bool> stopping_{false};
  std::atomic<bool> finishing_{false};
  std::atomic<std::uint64_t> published_{0};
  std::atomic<std::uint64_t> without_ros_{0};
  std::thread thread_;
};

}  // namespace lidard
