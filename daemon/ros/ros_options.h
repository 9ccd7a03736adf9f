// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "daemon/live/frame_queue.h"

namespace lidard {

/// Where the dynamic_reconfigure servers of the merged and virtual scans are.
enum class ReconfigureNames : std::uint8_t {
  entries,  ///< one below the node for each entry of the configuration
  node      ///< the node itself, for the first entry: as ira_laser_tools has it
};

/// How to appear in ROS.
struct RosOptions {
  std::string node_name = "lidard";
  std::vector<std::string> remappings = {};  ///< "from:=to", "__ns:=…", "__name:=…", "__master:=…"
  ReconfigureNames reconfigure = ReconfigureNames::entries;
  Backpressure backpressure = Backpressure::drop_oldest;
  bool clock = false;  ///< publish_clock() will be used
  /// Where diagnostics() comes by the clock on the wall: older items are errors. Empty, as in replay: never.
  std::optional<Span> longest_report_age = {};
};

}  // namespace lidard
