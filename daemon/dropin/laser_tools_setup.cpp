// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <set>

#include "core/base/angle.h"
#include "core/base/number_text.h"
#include "daemon/config/config.h"
#include "daemon/dropin/moving.h"
#include "daemon/ros/in/grid_limits.h"

namespace lidard {
namespace {

/// Parameters that laserscan_virtualizer reads from absolute names.
constexpr const char* absolute_keys[] = {"base_frame", "cloud_topic", "output_laser_topic",
                                         "virtual_laser_scan"};

/// The words of a list in order, without duplicates.
std::vector<std::string> words_of(const std::string& list) {
  std::vector<std::string> words;
  for (auto& word : split_words(list)) {
    if (std::find(words.begin(), words.end(), word) == words.end()) words.push_back(std::move(word));
  }
  return words;
}

/// Adds the grid. Numbers are clamped to their limits as by dynamic_reconfigure; the result must be valid.
void add_grid(Translation& node, KeyMap& entry) {
  OutputScanConfig output;
  for (const GridLimit& limit : grid_limits) {
    const std::string name(limit.name);
    const double given = node.number(name, limit.preset);
    const double value = std::clamp(given, limit.min, limit.max);
    if (value != given)
      node.warn("parameter ~" + name + " is " + number_text(given) + "; the limit is " + number_text(value));
    entry.emplace_back(name, value);
    for (const Key& key : output_keys(output)) {
      if (key.name == name) key.set(value);
    }
  }
  if (const auto made = make_grid(output.grid); !made)
    throw ConfigError("private parameters: " + made.reason());
}

/// Adds the grid and the keys of the configuration that are given as parameters.
void add_output(Translation& node, const Keys& keys, KeyMap& entry) {
  add_grid(node, entry);
  // The value that ira_laser_tools publishes for beams without a hit.
  entry.emplace_back("empty", node.text("empty", "range_max_plus_one"));
  for (const Key& key : keys) {
    if (key.kind == KeyKind::pose || key.kind == KeyKind::section || key.name == "beams") continue;
    if (const auto value = node.find(std::string(key.name))) entry.emplace_back(key.name, *value);
  }
}

/// Converts topics to sensors and appends their names; no name equals the topic of another sensor.
Sections::Entries sensors_of(const std::vector<std::string>& topics, std::vector<std::string>& names) {
  Sections::Entries sensors;
  for (const std::string& topic : topics) {
    std::set<std::string> used(names.begin(), names.end());
    for (const std::string& other : topics) {
      if (other != topic) used.insert(other.front() == '/' ? other.substr(1) : other);
    }
    names.push_back(unique_name(entry_name(topic), used));
    sensors.push_back({names.back(), {{"topic", topic}}});
  }
  return sensors;
}

std::vector<std::string> required_words(Translation& node, const char* name, const char* what) {
  auto words = words_of(node.text(name, ""));
  if (words.empty())
    throw ConfigError("parameter ~" + std::string(name) + " is empty; expected " + what +
                      " separated by blanks");
  return words;
}

/// Adds a filter of a chain to a merged scan, the window of its source and the vehicle. `in` begins the names
/// of its parameters. False: it has no counterpart, or the chain has two of this kind.
bool add_filter(const std::string& type, const std::string& in, Translation& node, KeyMap& entry,
                KeyMap& window) {
  KeyMap& vehicle = node.setup.keys.vehicle;
  const auto has = [&](const char* key) { return find_key(window, key) != nullptr; };
  const auto number = [&](const char* name, double missing) { return node.number(in + name, missing); };
  if (type == "ScanShadowsFilter") {
    *find_key(entry, "veil_filter") = true;
  } else if (type == "LaserScanRangeFilter" && !has("range_min")) {
    window.emplace_back("range_min", std::max(0.0, number("lower_threshold", 0)));
    window.emplace_back("range_max", std::clamp(number("upper_threshold", 10000), 0.0, 10000.0));
  } else if (type.rfind("LaserScanAngularBoundsFilter", 0) == 0 && !has("angle_min")) {
    // In place what lies between both is removed: the sector that stays begins at the upper one.
    const bool in_place = type.find("InPlace") != std::string::npos;
    window.emplace_back("angle_min", number(in_place ? "upper_angle" : "lower_angle", 0));
    window.emplace_back("angle_max", number(in_place ? "lower_angle" : "upper_angle", 0));
    if (!in_place) entry.insert(entry.end(), window.end() - 2, window.end());
  } else if (type == "LaserScanBoxFilter" && !node.flag(in + "invert") && vehicle.empty()) {
    const double x = number("min_x", -1), y = number("min_y", -1), x2 = number("max_x", 1),
                 y2 = number("max_y", 1);
    vehicle = {{"footprint", KeyList{KeyList{x, y}, KeyList{x2, y}, KeyList{x2, y2}, KeyList{x, y2}}},
               {"box_frame", node.text(in + "box_frame", "base_link")}};
  } else {
    return false;
  }
  return true;
}

}  // namespace

DropinSetup laser_merger_setup(const NodeParameters& parameters) {
  Translation node(parameters);
  const auto topics = required_words(node, "laserscan_topics", "topics of LaserScans");
  const std::string frame = node.text("destination_frame", "cart_frame");
  const std::string scan_topic = node.text("scan_destination_topic", "/scan_multi");
  std::vector<std::string> names;
  node.setup.keys.sensors = sensors_of(topics, names);
  KeyMap entry{{"laserscan_topics", KeyList(names.begin(), names.end())},
               {"destination_frame", frame},
               {"scan_destination_topic", scan_topic},
               {"cloud_destination_topic", node.text("cloud_destination_topic", "/merged_cloud")}};
  MergedScanConfig usual;
  add_output(node, merged_keys(usual), entry);
  node.setup.keys.vehicle = {{"base_frame", frame}};
  node.setup.keys.merged_scans = {{entry_name(scan_topic), std::move(entry)}};
  return node.finish();
}

DropinSetup laser_virtualizer_setup(const NodeParameters& parameters) {
  Translation node(parameters);
  const auto frames = required_words(node, "virtual_laser_scan", "frames");
  const std::string base = node.text("base_frame", "/cart_frame");
  std::vector<std::string> names;
  node.setup.keys.sensors = sensors_of({node.text("cloud_topic", "/cloud_pcd")}, names);
  KeyMap entry{{"cloud_topic", names.front()},
               {"base_frame", base},
               {"virtual_laser_scan", KeyList(frames.begin(), frames.end())},
               {"output_laser_topic", node.text("output_laser_topic", "")}};
  VirtualScanConfig usual;
  add_output(node, virtual_keys(usual), entry);
  if (parameters.count("min_height") + parameters.count("max_height") == 0)
    node.warn(
        "returns within 0.1 m of a plane are its scan (min_height, max_height); laserscan_virtualizer "
        "projects all returns, whatever their height");
  node.setup.keys.vehicle = {{"base_frame", base}};
  node.setup.keys.virtual_scans = {{"virtual_laser_scan", std::move(entry)}};
  return node.finish();
}

DropinSetup scan_unifier_setup(const NodeParameters& parameters) {
  Translation node(parameters);
  std::vector<std::string> names;
  node.setup.keys.sensors = sensors_of(required_words(node, "input_scans", "topics of LaserScans"), names);
  const std::string frame = node.text("frame", "base_link");
  const double step = pi_d / 360;
  KeyMap entry{{"laserscan_topics", KeyList(names.begin(), names.end())},     {"destination_frame", frame},
               {"scan_destination_topic", "scan_unified"}, {"angle_min", -pi_d + step / 100},
               {"angle_max", pi_d - step / 100},           {"angle_increment", step}};
  node.warn("a beam without return is +inf (theirs: range_max)");
  node.setup.keys.vehicle = {{"base_frame", frame}};
  node.setup.keys.merged_scans = {{"scan_unified", std::move(entry)}};
  return node.finish();
}

DropinSetup flat_scan_setup(const NodeParameters& parameters, const std::string& frame) {
  Translation node(parameters);
  std::string target = node.text("target_frame", "");
  if (target.empty()) target = frame;
  if (target.empty())
    throw ConfigError("parameter ~target_frame is empty, and the frame of the cloud is not in this file");
  KeyMap entry{{"cloud_topic", ""}, {"virtual_laser_scan", KeyList{target}}, {"output_laser_topic", "scan"}};
  constexpr std::pair<const char*, double> presets[] = {
      {"min_height", 0},   {"max_height", 10000},           {"angle_min", -pi_d},
      {"angle_max", pi_d}, {"angle_increment", pi_d / 180}, {"scan_time", 1.0 / 30}};
  for (const auto& [name, preset] : presets) entry.emplace_back(name, node.number(name, preset));
  entry.emplace_back("empty", node.flag("use_inf", "true") ? "inf" : "range_max_plus_one");
  node.warn("a scan is stamped by its first ray (theirs: as the cloud)");
  node.move("pointcloud_to_laserscan", entry);
  node.setup.keys.sensors = {{"cloud_in", {{"topic", "cloud_in"}}}};
  node.setup.keys.virtual_scans = {{"scan", std::move(entry)}};
  return node.finish();
}

DropinSetup scan_filters_setup(const NodeParameters& parameters, const std::string& frame) {
  if (frame.empty())
    throw ConfigError(
        "no sensor in this file has its scan; it stays in a launch file, `topic` reads its output");
  KeyMap window;
  KeyMap entry{{"laserscan_topics", ""},
               {"destination_frame", frame},
               {"scan_destination_topic", "scan_filtered"},
               {"veil_filter", false}};
  NodeParameters limits;  // without .inf, which is none
  for (const auto& one : parameters) {
    if (one.second.find("inf") == std::string::npos) limits.insert(one);
  }
  Translation node(limits);
  // read_launch.py numbers the elements of a list.
  for (const auto& [key, value] : parameters) {
    const std::size_t end = key.rfind("/type");
    if (end == std::string::npos || end + 5 != key.size() || key.find("/params/") != std::string::npos)
      continue;
    const std::string type = value.substr(value.rfind('/') + 1);
    if (!add_filter(type, key.substr(0, end) + "/params/", node, entry, window))
      node.warn(type + " was left out: a merged scan has none (that of a sensor: `filter`)");
  }
  node.warn("beams are 0.25 degrees apart (angle_increment; theirs: as the sensor has them)");
  entry.emplace_back("window", std::move(window));
  node.setup.keys.sensors = {{"source", {{"topic", "scan"}}}};
  node.setup.keys.merged_scans = {{"scan_filtered", std::move(entry)}};
  return node.setup;
}

NodeParameters with_absolute_names(NodeParameters own, const NodeParameters& absolute) {
  for (const char* key : absolute_keys) {
    const auto found = absolute.find(key);
    if (found != absolute.end()) own.insert(*found);
  }
  return own;
}

}  // namespace lidard
