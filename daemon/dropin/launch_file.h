// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include "daemon/dropin/moving.h"

namespace lidard {

/// A node of a launch file, or the parameters of a node.
struct LaunchNode {
  std::string name;           ///< with its namespace
  std::string package, type;  ///< of the nodelet, for nodelets; empty: not given by a parameter file
  std::string space;          ///< namespace with a / at the end
  std::vector<std::string> arguments;
  std::map<std::string, std::string> remaps;  ///< topics by their resolved names
  NodeParameters parameters;

  /// The resolved name of the node's `topic`, with remappings.
  std::string resolved(const std::string& topic) const;
};

/// The content of a launch file or a parameter file.
struct LaunchFile {
  std::vector<LaunchNode> nodes;
  std::vector<std::string> changes;  ///< parts that could not be read
  std::vector<std::string> remarks;  ///< about ignored parts
};

/// Reads a launch file with roslaunch; `arguments` are NAME:=VALUE. Starts no node. Throws ConfigError for an
/// invalid file and std::runtime_error if roslaunch or Python is missing.
LaunchFile read_launch(const std::string& file, const std::vector<std::string>& arguments);

}  // namespace lidard
