// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "daemon/pipeline/sink.h"
#include "daemon/ros/ros_queue.h"

namespace lidard {

class MasterClient;

/// ROS cannot be used as asked: a wrong name or address. A usage error.
class RosError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct RosOptions {
  std::string node_name = "lidard";
  std::vector<std::string> remappings;  ///< "from:=to", "__ns:=…", "__name:=…", "__master:=…"
  std::vector<OutputTopic> topics;      ///< output_topics()
  Backpressure backpressure = Backpressure::drop_oldest;
  bool clock = false;  ///< publish_clock() will be used
  /// Where diagnostics() comes by the clock on the wall: older items are errors. Empty, as in replay: never.
  std::optional<Span> longest_report_age;
};

/// A snapshot for status lines, diagnostics and tests.
struct RosStatus {
  bool master = false;              ///< the master answered lately
  bool connected = false;           ///< topics are advertised
  std::size_t subscribers = 0;      ///< of all frame topics together
  std::uint64_t published = 0;      ///< frames handed to roscpp
  std::uint64_t dropped = 0;        ///< frames dropped because the ROS thread was behind
  std::uint64_t without_ros = 0;    ///< frames that came while there was no master yet
  std::uint64_t foreign_stops = 0;  ///< how often somebody shut our node down from outside
  std::uint64_t ticks = 0;          ///< rounds of the ROS thread, at least 5 per second; for a watchdog
};

/// Something else that needs the ROS connection. All calls come from the master thread.
class RosClient {
 public:
  virtual ~RosClient() = default;
  /// ROS runs: node handles may be used. May wait for the master.
  virtual void connected() = 0;
  /// ROS ends. With `leave`, roscpp must not be told: its destructors would wait for the master.
  virtual void disconnected(bool leave) = 0;
  /// Twice a second while the master answers.
  virtual void poll(MasterClient& master) { static_cast<void>(master); }
  /// The master was restarted: tells it what the client publishes, with its type, and what it serves. False
  /// if the master did not answer every call.
  virtual bool register_again(MasterClient& master) {
    static_cast<void>(master);
    return true;
  }
  /// Frame topics that are to be advertised anew, since what they carry changed its shape.
  virtual std::vector<std::string> stale_topics() { return {}; }
  virtual std::vector<DiagnosticItem> diagnostics() { return {}; }
};

/// Publishes what the pipeline produces. The calls of FrameSink never wait (unless Backpressure::block); one
/// thread converts and publishes; another alone talks to the master, waits for it, registers again when it
/// was restarted.
class RosLink : public FrameSink {
 public:
  /// Calls ros::init, which no master is needed for; once per process. Throws RosError.
  explicit RosLink(RosOptions options);
  ~RosLink() override;

  /// To be called before start(). Shared, since a master thread that hangs at the end may outlive its owner.
  void add_client(std::shared_ptr<RosClient> client);
  void start();

  void scan(const OutputTopic& topic, const PlanarScan& scan, Stamp released) override;
  void cloud(const OutputTopic& topic, Cloud& cloud, Stamp released) override;
  void message(const OutputTopic& topic, const DeviceMessage& message, Stamp released) override;
  void transforms(const std::vector<StaticTransform>& transforms, Stamp released) override;
  void diagnostics(const std::vector<DiagnosticItem>& items, Stamp released) override;
  /// The time of a replay, on /clock.
  void publish_clock(Stamp now);

  /// Waits until the topics are advertised; false after `limit`.
  bool wait_for_master(Span limit);
  /// Waits until the frame topics have so many subscribers together; false after `limit`.
  bool wait_for_subscribers(std::size_t count, Span limit);
  /// Waits until every frame was published and taken by the subscribers' sockets; false after `limit`.
  bool flush(Span limit);

  RosStatus status() const;
  bool has_master() const;
  /// The threads that have not moved since the last call that returned "", see RosPulse::standing(). For a
  /// watchdog; always to be called by the same thread.
  std::string standing_threads();
  /// Why we have left ROS for good: the first daemon of our node name runs elsewhere. Else empty.
  std::string conflict() const;
  /// Ends everything within a second. False if the master hangs: then leave with std::quick_exit, since
  /// roscpp's destructors would wait for the master.
  bool stop();

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

/// Lets roscpp write its logs where it may: it aborts the process when $HOME is set but cannot be written.
void choose_ros_log_folder();
/// The master's address: "__master:=…" of the remappings, else $ROS_MASTER_URI, else the default, which is
/// then put into the environment. Throws RosError if it is not "http://host:port": roscpp would abort the
/// process.
std::string choose_master(const std::vector<std::string>& remappings);

}  // namespace lidard
