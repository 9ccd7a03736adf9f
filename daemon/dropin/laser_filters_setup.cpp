// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "daemon/config/config.h"
#include "daemon/dropin/moving.h"

namespace lidard {
namespace {

/// Adds a filter of a chain to a merged scan, the window of its source and the vehicle. `in` begins the names
/// of its parameters. False: it has no counterpart, or the chain has two of this kind.
bool add_filter(const std::string& type, const std::string& in, ParameterReader& reader, KeyMap& entry,
                KeyMap& window, KeyMap& vehicle) {
  const auto has = [&](const char* key) { return find_key(window, key) != nullptr; };
  const auto number = [&](const char* name, double missing) { return reader.number(in + name, missing); };
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
  } else if (type == "LaserScanBoxFilter" && !reader.flag(in + "invert") && vehicle.empty()) {
    const double x = number("min_x", -1), y = number("min_y", -1), x2 = number("max_x", 1),
                 y2 = number("max_y", 1);
    vehicle = {{"footprint", KeyList{KeyList{x, y}, KeyList{x2, y}, KeyList{x2, y2}, KeyList{x, y2}}},
               {"box_frame", reader.text(in + "box_frame", "base_link")}};
  } else {
    return false;
  }
  return true;
}

}  // namespace

DropinSetup scan_filters_setup(const NodeParameters& parameters, const std::string& frame) {
  if (frame.empty())
    throw ConfigError(
        "its scan is of no sensor in this file; it stays in a launch file, and `topic` reads the "
        "filtered scan");
  DropinSetup setup;
  KeyMap window, vehicle;
  KeyMap entry{{"laserscan_topics", ""},
               {"destination_frame", frame},
               {"scan_destination_topic", "scan_filtered"},
               {"veil_filter", false}};
  NodeParameters limits;  // without .inf, which is none
  for (const auto& one : parameters) {
    if (one.second.find("inf") == std::string::npos) limits.insert(one);
  }
  ParameterReader reader(limits);
  // read_launch.py numbers the elements of a list.
  for (const auto& [key, value] : parameters) {
    const std::size_t end = key.rfind("/type");
    if (end == std::string::npos || end + 5 != key.size() || key.find("/params/") != std::string::npos)
      continue;
    const std::string type = value.substr(value.rfind('/') + 1);
    if (!add_filter(type, key.substr(0, end) + "/params/", reader, entry, window, vehicle))
      setup.warnings.push_back("filter " + type +
                               " was left out: it has no counterpart for a merged scan, which "
                               "the filtered scan becomes");
  }
  setup.warnings.emplace_back(
      "the filtered scan has beams every 0.25 degrees (angle_increment; theirs: as the sensor)");
  entry.emplace_back("window", std::move(window));
  setup.keys = {{"vehicle", std::move(vehicle)},
                {"sensors", KeyMap{{"source", KeyMap{{"topic", "scan"}}}}},
                {"merged_scans", KeyMap{{"scan_filtered", std::move(entry)}}}};
  return setup;
}

}  // namespace lidard
