// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "daemon/dropin/launch_file.h"

namespace lidard {

/// Options of `lidard import`.
struct ImportOptions {
  std::string file;                    ///< a launch file, or a YAML file of parameters
  std::vector<std::string> arguments;  ///< of the launch file, NAME:=VALUE
  std::string output = "-";
  bool tables = false;  ///< prints the tables of all parameters instead
};

/// A configuration equivalent to nodes of other packages. The lists contain every parameter, pose and node
/// without counterpart.
struct ImportedConfig {
  KeyMap keys;                       ///< by section
  std::vector<std::string> changes;  ///< changes of outputs, poses and topics
  std::vector<std::string> stays;    ///< nodes and transforms that are needed in a launch file as before
  std::vector<std::string> remarks;  ///< parameters and nodes that are not needed
  std::size_t entries = 0;           ///< sensors, merged and virtual scans
};

/// Converts the nodes; a node with invalid parameters is skipped with a remark.
ImportedConfig import_nodes(const LaunchFile& launch);

/// `lidard import`: converts another driver's launch or parameter file to a configuration, with comments on
/// changes and on parameters that are not needed. Returns the exit code.
int run_import(const ImportOptions& options, std::ostream& out, std::ostream& err);

}  // namespace lidard
