// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/live/topic_watch.h"
#include "daemon/pipeline/sink.h"
#include "daemon/ros/master/environment.h"

namespace lidard {

class RosComponent;

/// A snapshot for status lines, diagnostics and tests.
struct RosStatus {
  bool master = false;              ///< the master answered lately
  bool connected = false;           ///< topics are advertised
  std::size_t subscribers = 0;      ///< of all frame topics together
  std::uint64_t published = 0;      ///< frames given to roscpp
  std::uint64_t dropped = 0;        ///< frames dropped because the ROS thread was behind
  std::uint64_t without_ros = 0;    ///< frames that came while there was no master yet
  std::uint64_t foreign_stops = 0;  ///< how often this node was shut down from outside
};

/// Publishes the frames of the workers, each through a PublisherThread. Only the master thread calls the
/// master, waits for it, and registers again after a restart; RosCallbackThread lives while ROS runs.
class RosConnection {
 public:
  /// Calls init_ros(), which may throw RosError. `topics` as of output_topics().
  RosConnection(RosOptions options, const std::vector<OutputTopic>& topics);
  ~RosConnection();
  RosConnection(const RosConnection&) = delete;
  RosConnection& operator=(const RosConnection&) = delete;

  /// Adds `component`, in the place of `former`, as soon as the master answers. Shared, since a master thread
  /// that hangs at the end may outlive its owner.
  void add(std::shared_ptr<RosComponent> component, std::shared_ptr<RosComponent> former = nullptr);
  void start();

  /// Receives the frames of a worker.
  FrameSink& sink(Worker worker = Worker::sensors);
  /// Publishes on other topics, see PublisherThread::set_topics(). To be called in the thread that uses
  /// sink().
  void set_topics(Worker worker, const std::vector<OutputTopic>& topics);
  /// The time of a replay, on /clock.
  void publish_clock(Stamp now);

  /// Waits until the topics are advertised; false after `limit`, or in a conflict().
  bool wait_for_master(Span limit);
  /// Waits until the frame topics have `count` subscribers together; false after `limit`.
  bool wait_for_subscribers(std::size_t count, Span limit);
  /// Waits until every frame was published and is in the subscribers' sockets; false after `limit`.
  bool flush(Span limit);

  /// Name of the node.
  std::string node() const;
  RosStatus status() const;
  /// Figures of a topic; `now` in steady time.
  TopicFigures figures(const OutputTopic& topic, Stamp now) const;
  /// The state of everything as /diagnostics has it: the newest items that the sinks got, then those of the
  /// connection, of the topics and of the components; `now` as FrameQueue::figures().
  std::vector<DiagnosticItem> diagnostics(Stamp now) const;
  bool has_master() const;
  /// The threads that have not moved since the last call that returned "", see ThreadWatch::standing(). For a
  /// watchdog; always to be called by the same thread.
  std::string standing_threads();
  /// Why the node name is not used, see NodeName::conflict(): then there will be no ROS. Else empty.
  std::string conflict() const;
  /// Ends all within a second. False if the master hangs: then end the process with std::quick_exit, since
  /// roscpp's destructors would wait for the master.
  bool stop();

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace lidard
