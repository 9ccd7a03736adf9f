// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "daemon/ros/ros_options.h"

namespace lidard {

struct Config;

/// What `lidard replay` was asked for.
struct ReplayOptions {
  std::string config;
  std::vector<std::string> captures;
  double rate = 1;                                 ///< of the recorded pace; 0: as fast as possible
  bool loop = false;                               ///< again and again, stamps going on
  double start = 0;                                ///< s into the capture
  double duration = -1;                            ///< s; negative: to the end
  double wait = 0;                                 ///< s between advertising the topics and the first frame
  bool restamp = false;                            ///< stamps as if it were live: the first packet comes now
  Span loop_gap = std::chrono::milliseconds(100);  ///< between the last packet of a round and the next round
  RosOptions ros;
  std::string bag;     ///< write here instead of to ROS
  std::string motion;  ///< with `bag`: a bag whose tf or odometry tells how the vehicle moved
};

/// Plays captures through the pipeline of a configuration into ROS or a bag. Messages go to `err`, the table
/// at the end to `out`. Returns the exit code.
int run_replay(const ReplayOptions& options, std::ostream& out, std::ostream& err);
/// The same with a configuration that is there already; `options.config` has no meaning.
int run_replay(const ReplayOptions& options, const Config& config, std::ostream& out, std::ostream& err);

}  // namespace lidard
