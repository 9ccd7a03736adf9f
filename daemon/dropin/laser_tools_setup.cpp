// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <set>

#include "core/base/angle.h"
#include "core/base/number_text.h"
#include "daemon/config/config.h"
#include "daemon/config/key_tables.h"
#include "daemon/dropin/moving.h"

namespace lidard {
namespace {

/// Parameters that laserscan_virtualizer reads from absolute names.
constexpr const char* absolute_keys[] = {"base_frame", "cloud_topic", "output_laser_topic",
                                         "virtual_laser_scan"};

using Warnings = std::vector<std::string>;

/// The words of a list in order, without duplicates.
std::vector<std::string> words_of(const std::string& list) {
  std::vector<std::string> words;
  for (auto& word : split_words(list)) {
    if (std::find(words.begin(), words.end(), word) == words.end()) words.push_back(std::move(word));
  }
  return words;
}

std::string free_name(const std::string& topic, std::set<std::string>& used) {
  const std::string name = entry_name(topic);
  std::string unique = name;
  for (int n = 2; !used.insert(unique).second; ++n) unique = name + "_" + std::to_string(n);
  return unique;
}

/// Adds the grid. Numbers are clamped to their limits as by dynamic_reconfigure; the result must be valid.
void add_grid(ParameterReader& reader, KeyMap& entry, Warnings& warnings) {
  OutputScanConfig output;
  for (const GridLimit& limit : grid_limits) {
    const std::string name(limit.name);
    const double given = reader.number(name, limit.preset);
    const double value = std::clamp(given, limit.min, limit.max);
    if (value != given)
      warnings.push_back("parameter ~" + name + " is " + number_text(given) + "; the limit is " +
                         number_text(value));
    entry.emplace_back(name, value);
    for (const auto& key : output_keys()) {
      if (key.name == name) key.set(output, value);
    }
  }
  if (const auto made = make_grid(output.grid); !made)
    throw ConfigError("private parameters: " + made.reason());
}

/// Adds the grid and the keys of the configuration that are given as parameters.
template <class Owner>
void add_output(ParameterReader& reader, const Keys<Owner>& keys, KeyMap& entry, Warnings& warnings) {
  add_grid(reader, entry, warnings);
  // The value that ira_laser_tools publishes for beams without a hit.
  entry.emplace_back("empty", reader.text("empty", "range_max_plus_one"));
  for (const Key& key : keys) {
    if (key.kind == KeyKind::pose || key.kind == KeyKind::section || key.name == "beams") continue;
    if (const auto value = reader.find(std::string(key.name))) entry.emplace_back(key.name, *value);
  }
}

/// Converts topics to sensors and appends their names; no name equals the topic of another sensor.
KeyMap sensors_of(const std::vector<std::string>& topics, std::vector<std::string>& names) {
  KeyMap sensors;
  for (const std::string& topic : topics) {
    std::set<std::string> used(names.begin(), names.end());
    for (const std::string& other : topics) {
      if (other != topic) used.insert(other.front() == '/' ? other.substr(1) : other);
    }
    names.push_back(free_name(topic, used));
    sensors.emplace_back(names.back(), KeyMap{{"topic", topic}});
  }
  return sensors;
}

std::vector<std::string> required_words(ParameterReader& reader, const char* name, const char* what) {
  auto words = words_of(reader.text(name, ""));
  if (words.empty())
    throw ConfigError("parameter ~" + std::string(name) + " is empty; expected " + what +
                      " separated by blanks");
  return words;
}

}  // namespace

DropinSetup laser_merger_setup(const NodeParameters& parameters) {
  DropinSetup setup;
  ParameterReader reader(parameters);
  const auto topics = required_words(reader, "laserscan_topics", "topics of LaserScans");
  const std::string frame = reader.text("destination_frame", "cart_frame");
  const std::string scan_topic = reader.text("scan_destination_topic", "/scan_multi");
  std::vector<std::string> names;
  KeyMap sensors = sensors_of(topics, names);
  KeyMap entry{{"laserscan_topics", key_value(names)},
               {"destination_frame", frame},
               {"scan_destination_topic", scan_topic},
               {"cloud_destination_topic", reader.text("cloud_destination_topic", "/merged_cloud")}};
  add_output(reader, merged_keys(), entry, setup.warnings);
  setup.keys = {{"vehicle", KeyMap{{"base_frame", frame}}},
                {"sensors", std::move(sensors)},
                {"merged_scans", KeyMap{{entry_name(scan_topic), std::move(entry)}}}};
  reader.remark_on_rest(setup.warnings);
  return setup;
}

DropinSetup laser_virtualizer_setup(const NodeParameters& parameters) {
  DropinSetup setup;
  ParameterReader reader(parameters);
  const auto frames = required_words(reader, "virtual_laser_scan", "frames");
  const std::string base = reader.text("base_frame", "/cart_frame");
  std::vector<std::string> names;
  KeyMap sensors = sensors_of({reader.text("cloud_topic", "/cloud_pcd")}, names);
  KeyMap entry{{"cloud_topic", names.front()},
               {"base_frame", base},
               {"virtual_laser_scan", key_value(frames)},
               {"output_laser_topic", reader.text("output_laser_topic", "")}};
  add_output(reader, virtual_keys(), entry, setup.warnings);
  if (parameters.count("min_height") + parameters.count("max_height") == 0)
    setup.warnings.emplace_back(
        "returns within 0.1 m of a plane are its scan (min_height, max_height); laserscan_virtualizer "
        "projects "
        "all returns, whatever their height");
  setup.keys = {{"vehicle", KeyMap{{"base_frame", base}}},
                {"sensors", std::move(sensors)},
                {"virtual_scans", KeyMap{{"virtual_laser_scan", std::move(entry)}}}};
  reader.remark_on_rest(setup.warnings);
  return setup;
}

DropinSetup scan_unifier_setup(const NodeParameters& parameters) {
  DropinSetup setup;
  ParameterReader reader(parameters);
  std::vector<std::string> names;
  KeyMap sensors = sensors_of(required_words(reader, "input_scans", "topics of LaserScans"), names);
  const std::string frame = reader.text("frame", "base_link");
  const double step = pi_d / 360;
  KeyMap entry{{"laserscan_topics", key_value(names)},     {"destination_frame", frame},
               {"scan_destination_topic", "scan_unified"}, {"angle_min", -pi_d + step / 100},
               {"angle_max", pi_d - step / 100},           {"angle_increment", step}};
  setup.warnings.emplace_back("a beam without return is +inf (theirs: range_max)");
  setup.keys = {{"vehicle", KeyMap{{"base_frame", frame}}},
                {"sensors", std::move(sensors)},
                {"merged_scans", KeyMap{{"scan_unified", std::move(entry)}}}};
  reader.remark_on_rest(setup.warnings);
  return setup;
}

DropinSetup flat_scan_setup(const NodeParameters& parameters, const std::string& frame, bool to_cloud) {
  DropinSetup setup;
  ParameterReader reader(parameters);
  std::string target = reader.text("target_frame", "");
  if (target.empty()) target = frame;
  if (target.empty())
    throw ConfigError("parameter ~target_frame is empty, and the frame of the source is not in this file");
  KeyMap entry{{to_cloud ? "laserscan_topics" : "cloud_topic", ""},
               {to_cloud ? "destination_frame" : "virtual_laser_scan", KeyValue()},
               {to_cloud ? "cloud_destination_topic" : "output_laser_topic", to_cloud ? "cloud" : "scan"}};
  entry[1].second = to_cloud ? KeyValue(target) : KeyValue(KeyList{target});
  constexpr std::pair<const char*, double> presets[] = {
      {"min_height", 0},   {"max_height", 10000},           {"angle_min", -pi_d},
      {"angle_max", pi_d}, {"angle_increment", pi_d / 180}, {"scan_time", 1.0 / 30}};
  for (const auto& [name, preset] : presets) {
    if (!to_cloud) entry.emplace_back(name, reader.number(name, preset));
  }
  if (!to_cloud) entry.emplace_back("empty", reader.flag("use_inf", "true") ? "inf" : "range_max_plus_one");
  reader.move("pointcloud_to_laserscan", entry, setup);
  setup.keys = {{"sensors", KeyMap{{"source", KeyMap{{"topic", to_cloud ? "scan_in" : "cloud_in"}}}}},
                {to_cloud ? "merged_scans" : "virtual_scans", KeyMap{{"scan", std::move(entry)}}}};
  reader.remark_on_rest(setup.warnings);
  return setup;
}

NodeParameters with_absolute_names(NodeParameters own, const NodeParameters& absolute) {
  for (const char* key : absolute_keys) {
    const auto found = absolute.find(key);
    if (found != absolute.end()) own.insert(*found);
  }
  return own;
}

}  // namespace lidard
