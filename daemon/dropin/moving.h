// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/commands/commands.h"
#include "daemon/config/config.h"
#include "drivers/key.h"

namespace lidard {

/// Values of a node's private parameters as text, by name; those of a list are separated by blanks.
using NodeParameters = std::map<std::string, std::string>;

/// What the parameters of another package's node ask for.
struct DropinSetup {
  KeyMap keys;                              ///< the configuration that does the same, by section
  ReplayOptions replay;                     ///< of a capture; without captures: live
  std::vector<std::string> warnings;        ///< of what the robot will notice
  std::vector<std::string> remarks;         ///< of what is no longer needed
  std::vector<StaticTransform> transforms;  ///< that the node publishes

  /// As the text of a configuration file.
  std::string yaml() const;
};

/// Parameters of another driver that have the same fate: a row of config/moving_over.tsv.
struct MovedParameter {
  std::string_view names;  ///< separated by blanks; a * at the end stands for whatever begins so
  std::string_view key;    ///< that gets their value; empty: there is no counterpart
  /// The value of the key; not set: the key stays unset. nullptr: the package's own setup sets the key.
  KeyValue (*convert)(const std::string& value);
  /// The values, separated by blanks, with which the parameter asks for nothing that a robot would miss; *:
  /// all.
  std::string_view idle;
  std::string_view remark;  ///< how the value becomes the key's, or why there is no counterpart
};

/// A topic or service of another driver.
struct MovedTopic {
  std::string_view name, type, ours;
};

/// How one moves over from a package.
struct MovedPackage {
  std::string_view name;
  std::string_view packages;  ///< in launch files, and our executables, separated by blanks
  std::string_view source;    ///< where the lists of parameters and topics come from
  std::vector<MovedParameter> parameters;
  std::vector<MovedTopic> topics;
};
const std::vector<MovedPackage>& moved_packages();
/// The package of that name; throws std::out_of_range where there is none.
const MovedPackage& moved_package(std::string_view name);
/// The package that knows most of the parameters; nullptr: none knows any.
const MovedPackage* package_of(const NodeParameters& parameters);

/// The tables of all packages, as they stand in config/doc/moving_over.md.
std::string moved_markdown();

/// The words of a list that blanks separate.
std::vector<std::string> split_words(std::string_view list);

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
  bool flag(const std::string& name, const std::string& missing = "false");
  /// Puts what the table of the package converts into `entry`, and remarks on what has no counterpart.
  void move(std::string_view package, KeyMap& entry, DropinSetup& setup);
  /// Remarks on what nobody took.
  void remark_on_rest(std::vector<std::string>& warnings) const;

 private:
  /// The names of a row, where a * at the end stands for all that were given and begin so.
  std::vector<std::string> given_names(std::string_view list);
  /// Reports the parameters of a row without counterpart, and why.
  void report_without_counterpart(const MovedParameter& row, DropinSetup& setup);

  NodeParameters left_;
  std::vector<std::string> known_;
};

/// A topic as the name of an entry in a configuration.
std::string entry_name(const std::string& topic);

/// The text as the value of a key; empty: not set.
KeyValue copied(const std::string& value);
/// The same of a frame, without the slash that old versions of tf wrote before it.
KeyValue as_frame(const std::string& value);

/// Removes keys of a sensor that its model does not take, and says so.
void drop_rejected(const Model& model, KeyMap& sensor, DropinSetup& setup);

/// Translates the parameters of laserscan_multi_merger (ira_laser_tools 1.0.7), with its defaults and limits.
/// Throws ConfigError for what cannot be; so do the following ones.
DropinSetup laser_merger_setup(const NodeParameters& parameters);
/// Translates the parameters of laserscan_virtualizer.
DropinSetup laser_virtualizer_setup(const NodeParameters& parameters);
/// laserscan_virtualizer reads four of its parameters from /laserscan_virtualizer whatever its own name is;
/// those stand in here for private ones that are not set.
NodeParameters with_absolute_names(NodeParameters own, const NodeParameters& absolute);
/// Translates the parameters of velodyne_driver's, velodyne_pointcloud's and velodyne_laserscan's nodes, with
/// their defaults.
DropinSetup velodyne_node_setup(const NodeParameters& parameters);
/// Translates the parameters of sick_safetyscanners_node.
DropinSetup safety_scanners_setup(const NodeParameters& parameters);
/// Translates the parameters of urg_node.
DropinSetup urg_node_setup(const NodeParameters& parameters);
/// Translates the parameters of sick_generic_caller of sick_scan_xd.
DropinSetup sick_scan_setup(const NodeParameters& parameters);

}  // namespace lidard
