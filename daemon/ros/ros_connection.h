// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "daemon/config/lanes.h"
#include "daemon/live/topic_watch.h"
#include "daemon/pipeline/sink.h"
#include "daemon/ros/ros_environment.h"

namespace lidard {

class RosComponent;

/// A snapshot for status lines, diagnostics and tests.
struct RosStatus {
  bool master = false;              ///< the master answered lately
  bool connected = false;           ///< topics are advertised
  std::size_t subscribers = 0;      ///< of all frame topics together
  std::uint64_t published = 0;      ///< frames handed to roscpp
  std::uint64_t dropped = 0;        ///< frames dropped because the ROS thread was behind
  std::uint64_t without_ros = 0;    ///< frames that came while there was no master yet
  std::uint64_t foreign_stops = 0;  ///< how often somebody shut our node down from outside
};

/// What another configuration changes of a connection to ROS.
struct RosChange {
  std::vector<OutputTopic> topics, clouds;  ///< as of the constructor of RosConnection
  /// Components to be replaced, and what comes in their place.
  std::vector<std::pair<std::shared_ptr<RosComponent>, std::shared_ptr<RosComponent>>> components;
  /// Called in the master thread: these are to be used instead of RosConnection::sink() from now on. When
  /// nobody uses the former ones any more, RosConnection::finish_change() has to be called.
  std::function<void(FrameSink& planes, FrameSink& clouds)> ready;
};

/// Publishes what the pipeline produces. Each lane has a thread that converts and publishes (RosLane);
/// another thread alone talks to the master, waits for it, registers again when it was restarted;
/// RosCallbackThread lives while ROS runs.
class RosConnection {
 public:
  /// Calls init_ros(), which may throw RosError. `topics` as output_topics() has them, of the lane of planes
  /// or of all, and `clouds` of the other one.
  RosConnection(RosOptions options, const std::vector<OutputTopic>& topics,
                const std::vector<OutputTopic>& clouds = {});
  ~RosConnection();
  RosConnection(const RosConnection&) = delete;
  RosConnection& operator=(const RosConnection&) = delete;

  /// To be called before start(). Shared, since a master thread that hangs at the end may outlive its owner.
  void add(std::shared_ptr<RosComponent> component);
  void start();

  /// Takes what a lane of the pipeline produces.
  FrameSink& sink(Lane lane = Lane::planes);
  /// Publishes on other topics. Those that stay the same lose no message and no subscriber; new ones are
  /// advertised when the master answers. One change at a time.
  void change(RosChange change);
  void finish_change();
  /// By how much the host's clock was set since the beginning: so much is added to the stamps of what goes
  /// out.
  void set_step(Span step);
  /// The time of a replay, on /clock.
  void publish_clock(Stamp now);

  /// Waits until the topics are advertised; false after `limit`.
  bool wait_for_master(Span limit);
  /// Waits until the frame topics have so many subscribers together; false after `limit`.
  bool wait_for_subscribers(std::size_t count, Span limit);
  /// Waits until every frame was published and taken by the subscribers' sockets; false after `limit`.
  bool flush(Span limit);

  /// Name of the node.
  std::string node() const;
  RosStatus status() const;
  /// How a topic does; `now` in the time without steps.
  TopicFigures figures(Lane lane, const OutputTopic& topic, Stamp now) const;
  /// What /diagnostics says of the connection, of the topics and of the components; `now` as
  /// FrameQueue::figures().
  std::vector<DiagnosticItem> diagnostics(Stamp now) const;
  bool has_master() const;
  /// The threads that have not moved since the last call that returned "", see RosPulse::standing(). For a
  /// watchdog; always to be called by the same thread.
  std::string standing_threads();
  /// Why we have left ROS for good: the first daemon of our node name runs elsewhere. Else empty.
  std::string conflict() const;
  /// Another program has a port of ours: is it a daemon of the same name, it shall have the name too, though
  /// all have waited for the master. We register 2 s after the master is there, unless the name is taken by
  /// then.
  void stand_back(bool ports_are_taken);
  /// Ends everything within a second. False if the master hangs: then leave with std::quick_exit, since
  /// roscpp's destructors would wait for the master.
  bool stop();

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace lidard
