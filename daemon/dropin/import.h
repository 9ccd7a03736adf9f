// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "daemon/dropin/import_poses.h"

namespace lidard {

/// Options of `lidard import`.
struct ImportOptions {
  std::string file;                    ///< a launch file, or a YAML file of parameters
  std::vector<std::string> arguments;  ///< of the launch file, NAME:=VALUE
  std::string output = "-";
  bool tables = false;  ///< prints the tables of all parameters instead
};

/// Converts the nodes; a node with invalid parameters is skipped with a remark.
ImportedConfig import_nodes(const LaunchFile& launch);

/// `lidard import`: converts another driver's launch or parameter file to a configuration, with comments on
/// changes and on parameters that are not needed. Returns the exit code.
int run_import(const ImportOptions& options, std::ostream& out, std::ostream& err);

}  // namespace lidard
