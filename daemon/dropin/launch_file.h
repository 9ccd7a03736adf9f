// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include "daemon/dropin/moving.h"

namespace lidard {

/// A node that a launch file starts, or the parameters of one.
struct LaunchNode {
  std::string name;           ///< with its namespace
  std::string package, type;  ///< of a nodelet its own; empty: a parameter file does not say
  std::string space;          ///< its namespace, with a / at the end
  std::vector<std::string> arguments;
  std::map<std::string, std::string> remaps;  ///< topics by their resolved names
  NodeParameters parameters;

  /// The topic that the node means by `topic`, with remappings.
  std::string resolved(const std::string& topic) const;
};

/// What a launch file or a parameter file asks for.
struct LaunchFile {
  std::vector<LaunchNode> nodes;
  std::vector<std::string> remarks;  ///< on what was not read
};

/// Reads the file, with roslaunch where it is installed; `arguments` are NAME:=VALUE. Nothing is started.
/// Throws ConfigError for a file that cannot be resolved, and std::runtime_error where Python is missing.
LaunchFile read_launch(const std::string& file, const std::vector<std::string>& arguments);

}  // namespace lidard
