// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <iosfwd>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "daemon/commands/commands.h"

namespace lidard {

/// Values of a node's private parameters as text, by name; those of a list are separated by blanks.
using NodeParameters = std::map<std::string, std::string>;

/// The node's name with its namespace: `name` or __name:=…, in __ns:=… or $ROS_NAMESPACE.
std::string full_node_name(const std::vector<std::string>& arguments, const std::string& name);

/// The private parameters of `node`: those of the master, for which it waits, and _name:=value of the
/// arguments, which win.
NodeParameters wait_for_parameters(const std::vector<std::string>& arguments, const std::string& node);

/// Takes a node's private parameters one by one; what is left over is unknown.
class ParameterReader {
 public:
  explicit ParameterReader(NodeParameters parameters) : left_(std::move(parameters)) {}

  /// The value, or `missing` where the parameter is not set.
  std::string text(const std::string& name, const std::string& missing);
  /// Empty where the parameter is not set.
  std::optional<std::string> find(const std::string& name);
  /// Throws ConfigError for what is no number, or no truth value.
  double number(const std::string& name, double missing);
  bool flag(const std::string& name);
  /// Remarks on what nobody took.
  void remark_on_rest(std::vector<std::string>& warnings) const;

 private:
  NodeParameters left_;
  std::vector<std::string> known_;
};

/// What the parameters of another package's node ask for.
struct DropinSetup {
  std::string yaml;                   ///< the configuration that does the same
  ReplayOptions replay;               ///< of a capture; without captures: live
  std::vector<std::string> warnings;  ///< of values that were changed and of parameters without effect
};

/// Translates the parameters of laserscan_multi_merger (ira_laser_tools 1.0.7), with its defaults and limits.
/// Throws ConfigError for what cannot be.
DropinSetup laser_merger_setup(const NodeParameters& parameters);
/// Translates the parameters of laserscan_virtualizer; throws ConfigError for what cannot be.
DropinSetup laser_virtualizer_setup(const NodeParameters& parameters);

/// laserscan_virtualizer reads four of its parameters from /laserscan_virtualizer whatever its own name is;
/// those stand in here for private ones that are not set.
NodeParameters with_absolute_names(NodeParameters own, const NodeParameters& absolute);

/// Translates the parameters of velodyne_driver's, velodyne_pointcloud's and velodyne_laserscan's nodes, with
/// their defaults. Throws ConfigError for a value that means nothing.
DropinSetup velodyne_node_setup(const NodeParameters& parameters);

/// Runs the program that `executable` (argv[0] without folder) stands for, a node of another package: reads
/// that node's private parameters from the master, for which it waits, and publishes what it did. Returns the
/// exit code; empty: it is `lidard` itself.
std::optional<int> run_dropin(const std::string& executable, const std::vector<std::string>& arguments,
                              std::ostream& out, std::ostream& err);

}  // namespace lidard
