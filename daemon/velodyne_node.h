// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <iosfwd>
#include <map>
#include <string>
#include <vector>

#include "daemon/replay.h"

namespace lidard {

/// Values of a node's private parameters as text, by name.
using NodeParameters = std::map<std::string, std::string>;

/// What the parameters of ros-drivers/velodyne's nodes ask for.
struct VelodyneNodeSetup {
  std::string yaml;                   ///< the configuration that does the same
  ReplayOptions replay;               ///< of the capture in `pcap`; without captures if there is none
  std::vector<std::string> warnings;  ///< of parameters without effect
};

/// Translates the parameters of velodyne_driver's, velodyne_pointcloud's and velodyne_laserscan's nodes, with
/// their defaults. Throws ConfigError for a value that means nothing.
VelodyneNodeSetup velodyne_node_setup(const NodeParameters& parameters);

/// The executable `velodyne_node`: stands in for those three nodes. Reads the private parameters from the
/// master, for which it waits, then publishes `velodyne_points` and `scan`. Returns the exit code.
int run_velodyne_node(const std::vector<std::string>& ros_arguments, std::ostream& out, std::ostream& err);

}  // namespace lidard
