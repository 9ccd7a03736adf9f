// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/in/output_items.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/base/angle.h"
#include "core/base/number_text.h"
#include "daemon/ros/in/grid_limits.h"

namespace lidard {
namespace {

/// Sets the values that depend on the items of a sensor. A width of 0 is all around, as in
/// velodyne_pointcloud (src/lib/rawdata.cc).
void complete(SensorConfig& sensor) {
  if (sensor.driver.view_width <= 0) sensor.driver.view_width = two_pi;
  set_ring_limits(sensor);
}

/// The increment in force, which may follow from the number of beams; setting it sets that number.
void make_increment(Key& key, ScanGridSpec& grid) {
  const auto made = make_grid(grid);
  if (!key.value.is_set()) key.value = made ? made->increment : 0.0;
  key.setter = [&grid](const KeyValue& value, const Form&) {
    grid.angle_increment = std::get<double>(value);
    grid.beams.reset();
  };
}

/// The items have the limits of their keys; those of ira_laser_tools' nodes have their own.
Keys output_items(Reconfigurable& output) {
  Keys items;
  for (Key key : output_keys(output.config)) {
    const GridLimit* const limit = grid_limit(key.name);
    const bool of_node = output.names == ReconfigureNames::node;
    const bool is_merged = output.id.kind == MakerId::Kind::merged;
    if (!(of_node ? limit != nullptr : key.live && (key.name != "profile" || is_merged))) continue;
    if (key.name == "angle_increment") make_increment(key, output.config.grid);
    if (of_node) key.lowest = limit->min, key.highest = limit->max;
    items.push_back(std::move(key));
  }
  return items;
}

/// A source that is a virtual scan of profile flatten; empty: there is none.
std::string flat_source(const MergedScanConfig& merged, const Config& config) {
  for (const std::string& source : merged.laserscan_topics) {
    for (const VirtualScanConfig& group : config.virtual_scans) {
      const auto& frames = group.virtual_laser_scan;
      const bool gives = group.output_laser_topic == source ||
                         std::find(frames.begin(), frames.end(), source) != frames.end();
      if (gives && group.output.profile == Profile::flatten && config.find_sensor(source) == nullptr)
        return source;
    }
  }
  return {};
}

Reconfigurable merged_output(const MergedScanConfig& merged, const Config& config) {
  Reconfigurable output;
  output.id = {MakerId::Kind::merged, merged.name};
  output.topics.push_back(merged.scan_destination_topic);
  for (const AlsoScanConfig& also : merged.also) output.topics.push_back(also.topic);
  if (!merged.status_topic.empty()) output.topics.push_back(merged.status_topic);
  output.free_required = merged.free_required;
  output.flat_source = flat_source(merged, config);
  output.config = merged.output;
  return output;
}

Reconfigurable virtual_output(const VirtualScanConfig& group) {
  Reconfigurable output;
  output.id = {MakerId::Kind::virtual_group, group.name};
  std::set<std::string> topics;
  for (const std::string& frame : group.virtual_laser_scan) {
    topics.insert(group.topic(frame));
    for (const AlsoScanConfig& also : group.also) topics.insert(group.topic(frame, &also));
  }
  output.topics.assign(topics.begin(), topics.end());
  output.config = group.output;
  return output;
}

/// The items of velodyne_driver and velodyne_pointcloud, with their limits (1.7.0, cfg/VelodyneNode.cfg and
/// cfg/TransformNode.cfg).
struct {
  std::string_view name;
  double min, max;
} constexpr sensor_limits[]{{"time_offset", -1, 1},
                            {"min_range", 0.1, 10},
                            {"max_range", 0.1, 200},
                            {"view_direction", -pi_d, pi_d},
                            {"view_width", 0, two_pi}};

/// Of a sensor these, and organize_cloud of velodyne_pointcloud, a flag.
Keys sensor_items(SensorConfig& sensor) {
  Keys items;
  for (const auto& limit : sensor_limits) {
    for (const Key& key : sensor_keys(sensor)) {
      if (key.name != limit.name || !accepts(sensor, key)) continue;
      items.push_back(key);
      items.back().lowest = limit.min, items.back().highest = limit.max;
    }
  }
  CloudOrder& order = sensor.layout.order;
  items.emplace_back("organize_cloud", KeyValue(order != CloudOrder::list), Form{KeyKind::flag, 0, 1},
                     "a row of the cloud for each firing sequence");
  items.back().setter = [&order](const KeyValue& value, const Form&) {
    order = std::get<bool>(value) ? CloudOrder::firing_rows : CloudOrder::list;
  };
  return items;
}

KeyValue value_in_force(const Key& item) { return item.value.is_set() ? item.value : item.otherwise; }

/// Applies a value of a request; a number at the limit of a key that may be unset stands for "not set".
std::string apply_item(const Key& item, const ItemValues& wanted) {
  const std::string name(item.name);
  const KeyValue& value = wanted.at(name);
  if (const auto* number = std::get_if<double>(&value)) {
    if (std::isnan(*number)) return name + " is not a number; expected one";
    const double within = std::clamp(*number, item.lowest, item.highest);
    const auto* const none = std::get_if<double>(&item.otherwise);
    item.set(none != nullptr && within == *none ? KeyValue() : within);
  } else if (const auto* word = std::get_if<std::string>(&value)) {
    std::string expected;
    for (const Word& one : item.words) expected.append(expected.empty() ? "" : ", ").append(one.text);
    const auto is_it = [&](const Word& one) { return one.text == *word; };
    if (std::none_of(item.words.begin(), item.words.end(), is_it))
      return name + " is '" + *word + "'; expected one of " + expected;
    item.set(value);
  } else {
    item.set(value);
  }
  return {};
}

/// Why these values contradict each other; empty: they do not.
std::string conflict(const Reconfigurable& output) {
  if (output.sensor) {
    const DriverConfig& driver = output.sensor->driver;
    return driver.max_range > driver.min_range
               ? ""
               : "max_range is not above min_range; expected min_range < max_range";
  }
  const OutputScanConfig& config = output.config;
  if (const auto grid = make_grid(config.grid); !grid) return grid.reason();
  if (config.min_height && config.max_height && *config.max_height <= *config.min_height)
    return "max_height is not above min_height; expected min_height < max_height";
  if (output.free_required > config.grid.range_max)
    return "range_max is below free_required of the configuration; expected " +
           number_text(output.free_required) + " or more";
  if (config.profile != Profile::flatten && !output.flat_source.empty())
    return "profile needs proof, but the source " + output.flat_source +
           " is a virtual scan of profile flatten; expected flatten";
  return {};
}

using ConfigMessage = dynamic_reconfigure::Config;

void add(ConfigMessage& config, const Key& item, const KeyValue& value) {
  const auto put = [&](auto& list, const auto& held) {
    auto& one = list.emplace_back();
    one.name = item.name;
    one.value = held;
  };
  if (const auto* number = std::get_if<double>(&value)) put(config.doubles, *number);
  if (const auto* word = std::get_if<std::string>(&value)) put(config.strs, *word);
  if (const auto* flag = std::get_if<bool>(&value)) put(config.bools, static_cast<std::uint8_t>(*flag));
}

/// The limit of a number.
KeyValue limit_of(const Key& item, double limit) {
  if (item.kind == KeyKind::flag) return limit > 0;
  return item.words.empty() ? KeyValue(limit) : KeyValue(std::string());
}

/// The meaning, the unit, and the value for "not set".
std::string description_of(const Key& item) {
  std::string text(item.meaning);
  if (!item.unit.empty()) text.append(", ").append(item.unit);
  const auto* none = std::get_if<double>(&item.otherwise);
  return none == nullptr ? text : text + "; " + number_text(*none) + ": none";
}

/// Every message of values names the one group there is (dynamic_reconfigure/GroupState.msg).
ConfigMessage with_group() {
  ConfigMessage config;
  config.groups.emplace_back();
  config.groups.back().name = "Default";
  config.groups.back().state = true;
  return config;
}

/// How rqt_reconfigure offers words: a Python literal, as parameter_generator writes it.
std::string edit_method(const Key& item) {
  if (item.words.empty()) return {};
  std::string entries;
  for (const Word& one : item.words) {
    entries += fmt::format(
        "{}{{'name': '{}', 'type': 'str', 'value': '{}', 'description': '', 'srcline': 0, 'srcfile': '', "
        "'cconsttype': 'const char * const', 'ctype': 'std::string'}}",
        entries.empty() ? "" : ", ", one.text, one.text);
  }
  return "{'enum_description': '" + description_of(item) + "', 'enum': [" + entries + "]}";
}

dynamic_reconfigure::ParamDescription described(const Key& item) {
  dynamic_reconfigure::ParamDescription description;
  description.name = item.name;
  description.type = item.kind == KeyKind::flag ? "bool" : item.words.empty() ? "double" : "str";
  description.description = description_of(item);
  description.edit_method = edit_method(item);
  return description;
}

}  // namespace

std::vector<Reconfigurable> changeable_outputs(const Config& config, ReconfigureNames names) {
  std::vector<Reconfigurable> outputs;
  for (const auto& merged : config.merged_scans) outputs.push_back(merged_output(merged, config));
  for (const auto& group : config.virtual_scans) outputs.push_back(virtual_output(group));
  std::set<std::string> used;
  for (Reconfigurable& output : outputs) {
    output.server = output.id.entry;
    while (!used.insert(output.server).second) output.server += "_virtual";
  }
  if (names == ReconfigureNames::node && outputs.empty()) {
    for (const SensorConfig& sensor : config.sensors) {
      if (sensor.model == nullptr || !sensor.model->has(Trait::revolutions)) continue;
      outputs.emplace_back().id.entry = sensor.name;
      outputs.back().sensor = sensor;
    }
  }
  if (names == ReconfigureNames::node && !outputs.empty()) {
    outputs.resize(1);
    outputs.front().server.clear();
  }
  for (Reconfigurable& output : outputs) output.names = names;
  return outputs;
}

Keys items_of(Reconfigurable& output) {
  return output.sensor ? sensor_items(*output.sensor) : output_items(output);
}

ItemValues values_of(Reconfigurable output) {
  ItemValues values;
  for (const Key& item : items_of(output)) values[std::string(item.name)] = value_in_force(item);
  return values;
}

std::string change(Reconfigurable& output, const ItemValues& wanted) {
  // Values that follow from the number of beams stay, whatever else changes.
  ItemValues values = values_of(output);
  for (const auto& [name, value] : wanted) {
    const auto known = values.find(name);
    if (known != values.end() && known->second.index() == value.index()) known->second = value;
  }
  Reconfigurable changed = output;
  for (const Key& item : items_of(changed)) {
    if (std::string complaint = apply_item(item, values); !complaint.empty()) return complaint;
  }
  if (changed.sensor) complete(*changed.sensor);
  if (std::string complaint = conflict(changed); !complaint.empty()) return complaint;
  output = std::move(changed);
  return {};
}

std::size_t beams_of(const OutputScanConfig& config) {
  const auto grid = make_grid(config.grid);
  return grid ? grid->beams : 0;
}

ItemValues read_values(const ConfigMessage& config) {
  ItemValues values;
  for (const auto& one : config.doubles) values[one.name] = one.value;
  // An integer stands for the same double.
  for (const auto& one : config.ints) values[one.name] = static_cast<double>(one.value);
  for (const auto& one : config.strs) values[one.name] = one.value;
  for (const auto& one : config.bools) values[one.name] = one.value != 0;
  return values;
}

ConfigMessage config_message(Reconfigurable output) {
  ConfigMessage config = with_group();
  for (const Key& item : items_of(output)) add(config, item, value_in_force(item));
  return config;
}

dynamic_reconfigure::ConfigDescription description_message(Reconfigurable output) {
  dynamic_reconfigure::ConfigDescription description;
  description.groups.emplace_back();
  description.groups.back().name = "Default";
  description.min = with_group();
  description.max = with_group();
  description.dflt = config_message(output);
  for (const Key& item : items_of(output)) {
    description.groups.back().parameters.push_back(described(item));
    add(description.min, item, limit_of(item, item.lowest));
    add(description.max, item, limit_of(item, item.highest));
  }
  return description;
}

}  // namespace lidard
