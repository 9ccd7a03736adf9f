// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "drivers/velodyne/web/velodyne_settings.h"

namespace lidard {

/// How patient the worker is. The web servers of these sensors are slow, and lose requests that come faster
/// than one per second.
struct VelodyneHttpTiming {
  Span pace = std::chrono::seconds(1);   ///< between the end of a request and the begin of the next
  Span limit = std::chrono::seconds(5);  ///< for one request
  Span save_limit = std::chrono::seconds(15);
  Span settle = std::chrono::seconds(2);  ///< between writing and looking whether it was taken
  Span after_save = std::chrono::seconds(10);
  Span first_retry = std::chrono::seconds(1);  ///< doubled after each failure in a row
  Span last_retry = std::chrono::seconds(60);
  Span spin_up = std::chrono::seconds(30);  ///< after a change of the speed
};

/// What is known of a sensor through its web interface.
struct VelodyneHttpState {
  VelodyneTree tree;                 ///< as last reported; empty while the sensor does not answer
  std::string serial;                ///< kept while it does not answer
  std::string trouble;               ///< what is wrong with asking and the remedy; empty: all is answered
  bool answered = false;             ///< anything usable so far
  std::string local_address;         ///< ours, as the sensor sees it
  std::vector<std::string> refused;  ///< changes that the sensor did not take, "rpm: 600 -> 1200"
  std::vector<std::string> unknown;  ///< wanted settings that it does not report
  bool settling = false;             ///< a change was written lately: the motor may still follow
  std::uint64_t requests = 0, failures = 0, writes = 0;
};

/// Asks one sensor for its state and, where the configuration allows it, writes the settings that differ.
/// Works on a thread of its own; never gives up, and never makes more than one request at a time.
class VelodyneHttp {
 public:
  /// `name` stands in the log.
  VelodyneHttp(std::string name, const IpAddress& address, const VelodyneControl& control,
               const VelodyneHttpTiming& timing = {});
  /// Stops.
  ~VelodyneHttp();

  /// Without `control.read` nothing happens.
  void start();
  /// Ends a request that is under way; returns as soon as the thread is gone.
  void stop();
  VelodyneHttpState state() const;

 private:
  class Worker;
  std::unique_ptr<Worker> worker_;
};

}  // namespace lidard
