// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "daemon/dropin/node_parameters.h"

namespace lidard {

/// What the parameters of a node of ira_laser_tools ask for.
struct LaserToolsSetup {
  std::string yaml;                   ///< the configuration that does the same
  std::vector<std::string> warnings;  ///< of values that were changed and of parameters without effect
};

/// Translates the parameters of laserscan_multi_merger (ira_laser_tools 1.0.7), with its defaults and limits.
/// Throws ConfigError for what cannot be.
LaserToolsSetup laser_merger_setup(const NodeParameters& parameters);
/// The same of laserscan_virtualizer.
LaserToolsSetup laser_virtualizer_setup(const NodeParameters& parameters);

/// laserscan_virtualizer reads four of its parameters from /laserscan_virtualizer whatever its own name is;
/// those stand in here for private ones that are not set.
NodeParameters with_absolute_names(NodeParameters own, const NodeParameters& absolute);

/// The executables `laserscan_multi_merger` and `laserscan_virtualizer`; return the exit code.
int run_laser_merger(const std::vector<std::string>& ros_arguments, std::ostream& out, std::ostream& err);
int run_laser_virtualizer(const std::vector<std::string>& ros_arguments, std::ostream& out,
                          std::ostream& err);

}  // namespace lidard
