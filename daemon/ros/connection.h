// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/health/diagnostics.h"
#include "daemon/ros/in/component.h"
#include "daemon/ros/master/environment.h"
#include "daemon/ros/master/node_name.h"
#include "daemon/ros/master/thread_watch.h"
#include "daemon/ros/out/publisher_thread.h"

namespace lidard {

/// The ROS node. Only the master thread calls the master, waits for it, and registers again after a restart;
/// PublisherThread publishes, and RosCallbackThread lives while ROS runs.
class RosConnection {
 public:
  /// Calls init_ros(), which may throw RosError. `topics` as of output_topics().
  RosConnection(const RosOptions& options, const std::vector<OutputTopic>& topics);
  /// Waits for the master if stop() returns false.
  ~RosConnection();
  RosConnection(const RosConnection&) = delete;
  RosConnection& operator=(const RosConnection&) = delete;

  /// Adds `component`, in place of `former`, as soon as the master answers. Shared, since the former one
  /// is in use until then.
  void add(std::shared_ptr<RosComponent> component, std::shared_ptr<RosComponent> former = nullptr);
  void start();

  /// Receives the frames of one pipeline.
  PublisherThread::Sink& sink() { return sink_; }
  /// Adds the sink of a further pipeline, in another thread; call it before start().
  PublisherThread::Sink& add_sink() { return publisher_.add_sink(); }
  PublisherThread& publisher() { return publisher_; }

  /// Waits until the topics are advertised; false after `limit`, or in a conflict().
  bool wait_for_master(Span limit);
  /// Waits until every frame was published and is in the subscribers' sockets; false after `limit`.
  bool flush(Span limit);

  /// Name of the node.
  const std::string& node() const { return node_; }
  /// The state of everything as /diagnostics has it: the newest items that the sink got, then those of the
  /// connection, of the topics and of the components; `now` without steps.
  std::vector<DiagnosticItem> diagnostics(Stamp now);
  /// The master answered lately.
  bool has_master() const { return master_present_; }
  /// How often this node was shut down from outside.
  std::uint64_t foreign_stops() const { return foreign_stops_; }
  /// The threads that have not moved since the last call that returned "", see ThreadWatch::stalled(). For a
  /// watchdog; always to be called by the same thread.
  std::string stalled_threads() { return watch_.stalled(master_present_); }
  /// Why the node name is not used, see NodeName::conflict(): then there will be no ROS. Else empty.
  std::string conflict() const { return name_.conflict(); }
  /// Ends all within a second. False if the master hangs: then end the process with std::quick_exit, since
  /// roscpp's destructors would wait for the master.
  bool stop();

 private:
  using Clock = std::chrono::steady_clock;
  using Component = std::shared_ptr<RosComponent>;
  struct Newest {
    std::vector<DiagnosticItem> items;
    Clock::time_point at;
  };

  void accept_items(std::size_t sink, const std::vector<DiagnosticItem>& items);
  std::vector<DiagnosticItem> own_items(Stamp now);
  DiagnosticItem own_status() const;
  void judge_own_status(DiagnosticItem& item) const;

  // Of the master thread.
  void run_master();
  void do_round(MasterClient& master);
  void master_answered(MasterClient& master, int pid);
  void master_silent(const MasterClient& master);
  void register_at(MasterClient& master);
  void change_components();
  bool start_ros();
  void end_ros(bool leave);
  void restart_after_foreign_stop(MasterClient& master);
  void publish_diagnostics();
  std::vector<DiagnosticItem> aged_items(const Newest& newest) const;

  const RosOptions options_;
  const std::string master_uri_, node_;
  NodeName name_;
  ThreadWatch watch_;
  PublisherThread publisher_;
  PublisherThread::Sink& sink_;

  std::atomic<bool> stopping_{false};
  std::atomic<bool> master_asked_{false}, master_present_{false};
  std::atomic<bool> master_ended_{false};
  std::atomic<bool> ended_clean_{true};
  std::atomic<bool> lacks_threads_{false};
  std::atomic<bool> news_{false};  // for /diagnostics, to be published at once
  std::atomic<std::uint64_t> foreign_stops_{0};
  std::atomic<Clock::time_point> last_foreign_stop_{Clock::time_point()};
  // After a stall of the process the master thread may run first, and must not report the others as dead.
  std::atomic<Clock::time_point> awake_since_{Clock::now()};
  std::thread master_thread_;

  mutable std::mutex mutex_;
  std::condition_variable wake_;
  // Guarded by mutex_:
  std::vector<std::pair<Component, Component>> changes_;  // former and next one
  std::vector<Newest> newest_;                            // of each sink
  std::vector<DiagnosticItem> component_items_;

  // Of the master thread:
  std::vector<Component> components_;
  std::unique_ptr<RosCallbackThread> callbacks_;  // while ROS runs
  ros::Publisher diagnostics_;                    // while ROS runs
  Clock::time_point last_round_ = Clock::now();
  bool running_ = false;
  bool registered_ = false;
  int master_pid_ = 0;
  std::uint32_t service_port_ = 0;
  bool noticed_ = false;  // that the master does not answer
  Clock::time_point next_notice_ = Clock::now();
  Clock::time_point next_diagnostics_ = Clock::now();
};

}  // namespace lidard
