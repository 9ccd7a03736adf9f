// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "daemon/dropin/launch_file.h"

namespace lidard {

/// What `lidard import` was asked for.
struct ImportOptions {
  std::string file;                    ///< a launch file, or a YAML file of parameters
  std::vector<std::string> arguments;  ///< of the launch file, NAME:=VALUE
  std::string output = "-";
  bool tables = false;  ///< what becomes of every parameter, instead
};

/// A configuration that does what the nodes of other packages did. Every parameter and node without
/// counterpart is in one of the lists.
struct ImportedConfig {
  KeyMap keys;                       ///< by section
  std::vector<std::string> changes;  ///< of what the robot will notice
  std::vector<std::string> remarks;  ///< on what is no longer needed, or stays as it is
  std::size_t entries = 0;           ///< sensors, merged and virtual scans
};

/// What the nodes did; a node whose parameters mean nothing is left out with a remark.
ImportedConfig import_nodes(const LaunchFile& launch);

/// `lidard import`: writes the configuration that does what another driver's launch or parameter file did,
/// and below it, as comments, what changes and what is no longer needed. Returns the exit code.
int run_import(const ImportOptions& options, std::ostream& out, std::ostream& err);

}  // namespace lidard
