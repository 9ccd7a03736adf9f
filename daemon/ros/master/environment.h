// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/base/host_clock.h"
#include "daemon/config/config.h"

namespace lidard {

/// How to handle a frame while earlier frames are still queued for the publishing thread.
enum class Backpressure : std::uint8_t {
  drop_oldest,  ///< live: the sensor thread never waits; dropped frames are counted
  block         ///< replay: the calling thread waits; no frame is lost
};

/// Names of the dynamic_reconfigure servers.
enum class ReconfigureNames : std::uint8_t {
  entries,  ///< one below the node for each merged scan and group of virtual scans
  node      ///< the node itself, for the first of them, as ira_laser_tools has it; without any for the first
            ///< Velodyne, with the items of velodyne_driver and velodyne_pointcloud
};

/// Options of the ROS node.
struct RosOptions {
  std::string node_name = "lidard";
  std::vector<std::string> remappings = {};  ///< "from:=to", "__ns:=…", "__name:=…", "__master:=…"
  ReconfigureNames reconfigure = ReconfigureNames::entries;
  Backpressure backpressure = Backpressure::drop_oldest;
  /// Between the stamps of messages and those of the pipelines; by default they are the same.
  std::shared_ptr<const ClockStep> clock_step = std::make_shared<ClockStep>();
  bool clock = false;  ///< publish_clock() will be used
  /// For diagnostics() by wall clock: older items are errors. Empty, as in replay: never.
  std::optional<Span> longest_report_age = {};
};

/// A usage error of ROS: a wrong name or address.
class RosError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Why other nodes will not reach this one at $ROS_HOSTNAME or $ROS_IP; empty: no reason is known. Needs a
/// second at most.
std::string own_address_warning();

/// Calls ros::init, which no master is needed for; once per process. Throws RosError.
void init_ros(const RosOptions& options);
/// Throws RosError for names of topics that ROS rejects. After init_ros().
void check_ros_names(const std::vector<OutputTopic>& topics);
/// Sets a writable folder for roscpp's logs: roscpp aborts the process when $HOME is set but cannot be
/// written.
void choose_ros_log_folder();
/// The master's address: "__master:=…" of the remappings, else $ROS_MASTER_URI, else the default, which is
/// then put into the environment. Throws RosError if it is not "http://host:port": roscpp would abort the
/// process.
std::string choose_master(const std::vector<std::string>& remappings);

}  // namespace lidard
