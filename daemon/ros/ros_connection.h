// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

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

/// Publishes what the pipeline produces. The calls of FrameSink never wait (unless Backpressure::block); one
/// thread converts and publishes; another alone talks to the master, waits for it, registers again when it
/// was restarted; a third, RosCallbackThread, lives while ROS runs.
class RosConnection : public FrameSink {
 public:
  /// Calls init_ros(), which may throw RosError. `topics` as output_topics() has them.
  RosConnection(RosOptions options, const std::vector<OutputTopic>& topics);
  ~RosConnection() override;

  /// To be called before start(). Shared, since a master thread that hangs at the end may outlive its owner.
  void add(std::shared_ptr<RosComponent> component);
  void start();

  void scan(const OutputTopic& topic, const PlanarScan& scan, Stamp released) override;
  void cloud(const OutputTopic& topic, Cloud& cloud, Stamp released) override;
  void message(const OutputTopic& topic, const DeviceMessage& message, Stamp released) override;
  void transforms(const std::vector<StaticTransform>& transforms, Stamp released) override;
  void diagnostics(const std::vector<DiagnosticItem>& items, Stamp released) override;
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
  /// How a topic does, `now` on the host's clock.
  TopicFigures figures(const OutputTopic& topic, Stamp now) const;
  /// The connection's item of /diagnostics.
  DiagnosticItem own_status() const;
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
