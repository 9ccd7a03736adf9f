// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "daemon/live/division.h"
#include "daemon/live/sensor_loop.h"

namespace lidard {

/// The second thread of a daemon, so that planar scanners and what is merged of them never wait for clouds:
/// it works on Division::clouds, and forwards the scans that the sensor thread merges. The thread starts when
/// there are sensors for it. All calls come from the sensor thread unless said.
class CloudWorker {
 public:
  /// The arguments must outlive this; `sensors`: the loop of the sensor thread.
  CloudWorker(const Config& part, DaemonClock& clock, BlackBox& box, TransformSource& transforms,
              DiagnosticSink& sink, SensorLoop& sensors);

  /// Starts the thread if the part has sensors. Throws std::system_error.
  void start(const Config& part);
  /// Calls `first` and applies another configuration, in the thread; then calls `then` in the sensor thread.
  void configure(std::shared_ptr<const Division> division, std::function<void()> first,
                 std::function<void()> then);
  /// Calls `then` in the sensor thread as soon as all that was asked for before is done.
  void when_done(std::function<void()> then);
  /// Runs a task for the pipeline in the thread if that has the sensor, or if `sensor` is empty; false: it
  /// does not have it. Thread-safe.
  bool post(const std::string& sensor, std::function<void(Pipeline&, Stamp)> task);
  /// True if the thread has not moved since the last call that returned false.
  bool is_stalled();
  /// Adds the item on scans that are forwarded, if any are.
  void add_items(std::vector<DiagnosticItem>& items) const;
  /// Ends the thread; false if it hangs.
  bool stop();

 private:
  void run();
  void forward(const std::string& source, const PlanarScan& scan, Stamp now);
  void set_part(const Config& part);
  void in_thread(std::function<void()> task, std::function<void()> then);

  DaemonClock& clock_;
  SensorLoop& sensors_;
  SensorLoop loop_;
  std::thread thread_;
  std::atomic<bool> ended_{false};
  std::uint64_t rounds_ = 0;
  bool forwards_ = false;
  std::atomic<int> waiting_{0};  // scans that the sensor thread has not got yet
  std::atomic<std::uint64_t> dropped_{0};
  std::atomic<Stamp> dropped_at_{Stamp{}};  // the last time
  std::mutex mutex_;
  // Guarded by mutex_:
  std::set<std::string> names_;  // of the sensors; empty: the thread may not run
};

}  // namespace lidard
