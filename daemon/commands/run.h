// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

#include "daemon/ros/ros_options.h"

namespace lidard {

struct Config;

/// The daemon: listens to the configured sensors and publishes until SIGTERM or SIGINT. Returns the exit
/// code.
int run_daemon(const Config& config, RosOptions ros, std::ostream& err);
/// Runs the daemon with the configuration that the file holds.
int run_daemon(const std::string& config_file, const std::vector<std::string>& ros_arguments,
               std::ostream& err);

}  // namespace lidard
