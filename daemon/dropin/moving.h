// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/commands/commands.h"
#include "daemon/config/config.h"
#include "drivers/key.h"

namespace lidard {

/// Values of a node's private parameters as text, by name; elements of a list are separated by blanks.
using NodeParameters = std::map<std::string, std::string>;

/// The keys of a configuration by section, and in most sections by entry.
struct Sections {
  using Entries = std::vector<std::pair<std::string, KeyMap>>;
  KeyMap vehicle;
  Entries sensors, merged_scans, virtual_scans;

  /// The text of a configuration file, without empty sections.
  std::string yaml() const;
};

/// The equivalent of the parameters of another package's node.
struct DropinSetup {
  Sections keys;
  ReplayOptions replay;                     ///< replay of a capture; without captures: live
  std::vector<std::string> warnings;        ///< changes of behaviour
  std::vector<std::string> remarks;         ///< parameters that are not needed
  std::vector<StaticTransform> transforms;  ///< published by the node
};

/// Parameters of another driver with the same conversion: a row of config/moving_over.tsv.
struct MovedParameter {
  std::string_view names;  ///< separated by blanks; a * at the end matches any rest
  std::string_view key;    ///< the key that gets their value; empty: no counterpart
  /// Converts the value; the result may be "not set". nullptr: the package's setup sets the key.
  KeyValue (*convert)(const std::string& value);
  /// Values without effect for the robot, separated by blanks; *: all values.
  std::string_view idle;
  std::string_view remark;  ///< how the value is converted, or why there is no counterpart
};

/// A topic or service of another driver.
struct MovedTopic {
  std::string_view name, type, ours;
};

/// The conversion table of a package.
struct MovedPackage {
  std::string_view name;
  std::string_view packages;  ///< names in launch files and of lidard's executables, separated by blanks
  std::string_view source;    ///< source of the lists of parameters and topics
  std::string_view needed;    ///< parameters of which a parameter file of the package has one
  std::string_view types;     ///< parts of the names of its executables that are translated; *: all
  std::vector<MovedParameter> parameters;
  std::vector<MovedTopic> topics;
};
const std::vector<MovedPackage>& moved_packages();
/// The package of that name; throws std::out_of_range if there is none.
const MovedPackage& moved_package(std::string_view name);
/// The package of a parameter file's node: by its name, or by two of its parameters that few drivers have.
/// nullptr: not known, or contradictory. `word` becomes the package's word that the node is called by.
const MovedPackage* package_of(const std::string& node, const NodeParameters& parameters, std::string& word);

/// The tables of all packages, as in config/doc/moving_over.md.
std::string moved_markdown();

/// The words of a list, separated by blanks.
std::vector<std::string> split_words(std::string_view list);

/// The translation of a node's private parameters: reads them and collects their equivalent. Parameters that
/// were not read are unknown.
class Translation {
 public:
  explicit Translation(NodeParameters parameters) : left_(std::move(parameters)) {}

  /// The value, or `missing` if the parameter is not set.
  std::string text(const std::string& name, const std::string& missing);
  /// Empty if the parameter is not set.
  std::optional<std::string> find(const std::string& name);
  /// These throw ConfigError for a value that is not a number or a truth value.
  double number(const std::string& name, double missing);
  bool flag(const std::string& name, const std::string& missing = "false");
  /// Converts parameters by the table of the package into `entry` and reports those without counterpart.
  void move(std::string_view package, KeyMap& entry);
  /// Reports a change of behaviour.
  void warn(std::string text) { setup.warnings.push_back(std::move(text)); }
  /// The setup, which reports parameters that were not read.
  DropinSetup finish();

  DropinSetup setup;

 private:
  /// The names of a row; a * at the end is replaced by all given names that match.
  std::vector<std::string> given_names(std::string_view list);
  void report_without_counterpart(const MovedParameter& row);

  NodeParameters left_;
  std::vector<std::string> known_;
};

/// The value of a key; nullptr: it is not there.
KeyValue* find_key(KeyMap& map, std::string_view key);
/// The text of a key; empty: it has none.
std::string text_of(KeyMap& map, std::string_view key);
void erase_key(KeyMap& map, std::string_view key);

/// Converts a topic to the name of an entry in a configuration.
std::string entry_name(const std::string& topic);
/// The name, with a number where it is used already; the result is used then.
std::string unique_name(const std::string& name, std::set<std::string>& used);

/// Converts text to the value of a key; empty: not set.
KeyValue copied(const std::string& value);
/// The same for a frame, without the leading slash of old versions of tf.
KeyValue as_frame(const std::string& value);

/// Another package's name of a model, and the name here.
struct ModelName {
  std::string_view theirs, ours;
};
using ModelNames = std::vector<ModelName>;
/// The model that the value of `parameter` names, in the package or here; throws ConfigError with these
/// names.
const Model& model_named(const ModelNames& names, const std::string& parameter, const std::string& value);

/// Translates the parameters of laserscan_multi_merger (ira_laser_tools 1.0.7), with its defaults and limits.
/// This and the following functions throw ConfigError for impossible values.
DropinSetup laser_merger_setup(const NodeParameters& parameters);
/// Translates the parameters of laserscan_virtualizer.
DropinSetup laser_virtualizer_setup(const NodeParameters& parameters);
/// laserscan_virtualizer reads four of its parameters from /laserscan_virtualizer, whatever its name is;
/// these are used for private parameters that are not set.
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
/// The same for LMS1xx_node, the node `type` of sick_tim, nebula's Velodyne nodes, scan_unifier_node of
/// cob_scan_unifier, scan_to_scan_filter_chain for a sensor in `frame`, and pointcloud_to_laserscan, where
/// `frame` stands in for an empty target_frame.
DropinSetup lms1xx_setup(const NodeParameters& parameters);
DropinSetup sick_tim_setup(const std::string& type, const NodeParameters& parameters);
DropinSetup nebula_setup(const NodeParameters& parameters);
DropinSetup scan_unifier_setup(const NodeParameters& parameters);
DropinSetup scan_filters_setup(const NodeParameters& parameters, const std::string& frame);
DropinSetup flat_scan_setup(const NodeParameters& parameters, const std::string& frame);

}  // namespace lidard
