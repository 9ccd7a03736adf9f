// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "daemon/commands/replay.h"
#include "daemon/dropin/node_parameters.h"

namespace lidard {

/// What the parameters of ros-drivers/velodyne's nodes ask for.
struct VelodyneNodeSetup {
  std::string yaml;                   ///< the configuration that does the same
  ReplayOptions replay;               ///< of the capture in `pcap`; without captures if there is none
  std::vector<std::string> warnings;  ///< of parameters without effect
};

/// Translates the parameters of velodyne_driver's, velodyne_pointcloud's and velodyne_laserscan's nodes, with
/// their defaults. Throws ConfigError for a value that means nothing.
VelodyneNodeSetup velodyne_node_setup(const NodeParameters& parameters);

/// The name of the node unless __name:= says otherwise.
constexpr const char* velodyne_node_name = "velodyne_node";

/// The executable `velodyne_node`: stands in for those three nodes. Reads the private parameters from the
/// master, for which it waits, then publishes `velodyne_points` and `scan`. Returns the exit code.
int run_velodyne_node(const std::vector<std::string>& ros_arguments, std::ostream& out, std::ostream& err);

}  // namespace lidard
