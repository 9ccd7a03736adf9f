// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace lidard {

/// Where the dynamic_reconfigure servers of the merged and virtual scans are.
enum class ReconfigureNames : std::uint8_t {
  entries,  ///< one below the node for each entry of the configuration
  node      ///< the node itself, for the first entry: as ira_laser_tools has it
};

/// How to appear in ROS.
struct RunOptions {
  std::vector<std::string> ros_arguments;
  std::string node_name = "lidard";
  ReconfigureNames reconfigure = ReconfigureNames::entries;
};

}  // namespace lidard
