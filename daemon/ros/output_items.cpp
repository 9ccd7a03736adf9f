// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/output_items.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/base/number_text.h"
#include "daemon/config/grid_limits.h"
#include "daemon/config/key_tables.h"

namespace lidard {
namespace {

/// The increment in force, which may follow from the number of beams; who sets it decides that number.
void follow_increment(OutputItem& item) {
  item.get = [](const OutputScanConfig& config) {
    const auto grid = make_grid(config.grid);
    return key_value(config.grid.angle_increment.value_or(grid ? grid->increment : 0));
  };
  item.set = [](OutputScanConfig& config, const KeyValue& value) {
    config.grid.angle_increment = std::get<double>(value);
    config.grid.beams.reset();
  };
}

/// What a configuration may hold lies within the limits of its keys; those of ira_laser_tools' nodes are
/// their own.
std::vector<OutputItem> items_of(OutputId::Kind kind, ReconfigureNames names) {
  std::vector<OutputItem> items;
  for (OutputItem item : output_keys()) {
    const GridLimit* const limit = grid_limit(item.name);
    const bool wanted = names == ReconfigureNames::node
                            ? limit != nullptr
                            : item.live && (item.name != "profile" || kind == OutputId::Kind::merged);
    if (!wanted) continue;
    if (names == ReconfigureNames::node) item.lowest = limit->min, item.highest = limit->max;
    if (item.name == "angle_increment") follow_increment(item);
    items.push_back(std::move(item));
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

ChangeableOutput merged_output(const MergedScanConfig& merged, const Config& config, ReconfigureNames names) {
  ChangeableOutput output;
  output.id = {OutputId::Kind::merged, merged.name};
  output.topics.push_back(merged.scan_destination_topic);
  for (const AlsoScanConfig& also : merged.also) output.topics.push_back(also.topic);
  if (!merged.status_topic.empty()) output.topics.push_back(merged.status_topic);
  output.free_required = merged.free_required;
  output.flat_source = flat_source(merged, config);
  output.config = merged.output;
  output.items = items_of(output.id.kind, names);
  return output;
}

ChangeableOutput virtual_output(const VirtualScanConfig& group, ReconfigureNames names) {
  ChangeableOutput output;
  output.id = {OutputId::Kind::virtual_group, group.name};
  output.topics = group.virtual_laser_scan;
  if (!group.output_laser_topic.empty()) output.topics = {group.output_laser_topic};
  output.config = group.output;
  output.items = items_of(output.id.kind, names);
  return output;
}

/// A value as a request may hold it; a number at the limit of a key that may be unset stands for "not set".
std::string take(const OutputItem& item, const ItemValues& wanted, OutputScanConfig& config) {
  const std::string name(item.name);
  const auto number = wanted.numbers.find(name);
  const auto word = wanted.words.find(name);
  if (item.words.empty() && number != wanted.numbers.end()) {
    if (std::isnan(number->second)) return name + " is not a number; expected one";
    const double value = std::clamp(number->second, item.lowest, item.highest);
    const auto* const none = std::get_if<double>(&item.otherwise);
    item.set(config, none != nullptr && value == *none ? KeyValue() : value);
  } else if (!item.words.empty() && word != wanted.words.end()) {
    std::string expected;
    for (const auto one : item.words) expected.append(expected.empty() ? "" : ", ").append(one);
    if (std::find(item.words.begin(), item.words.end(), word->second) == item.words.end())
      return name + " is '" + word->second + "'; expected one of " + expected;
    item.set(config, word->second);
  }
  return {};
}

/// What speaks against these values together.
std::string conflict(const OutputScanConfig& config, const ChangeableOutput& output) {
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

}  // namespace

std::vector<ChangeableOutput> changeable_outputs(const Config& config, ReconfigureNames names) {
  std::vector<ChangeableOutput> outputs;
  for (const auto& merged : config.merged_scans) outputs.push_back(merged_output(merged, config, names));
  for (const auto& group : config.virtual_scans) outputs.push_back(virtual_output(group, names));
  std::set<std::string> taken;
  for (ChangeableOutput& output : outputs) {
    output.server = output.id.entry;
    while (!taken.insert(output.server).second) output.server += "_virtual";
  }
  if (names == ReconfigureNames::node && !outputs.empty()) {
    outputs.resize(1);
    outputs.front().server.clear();
  }
  return outputs;
}

ItemValues values_of(const ChangeableOutput& output) {
  ItemValues values;
  for (const OutputItem& item : output.items) {
    KeyValue value = item.get(output.config);
    if (!value.is_set()) value = item.otherwise;
    if (item.words.empty())
      values.numbers[std::string(item.name)] = std::get<double>(value);
    else
      values.words[std::string(item.name)] = std::get<std::string>(value);
  }
  return values;
}

std::string change(ChangeableOutput& output, const ItemValues& wanted) {
  // What follows from the number of beams stays as it is, whatever else changes.
  ItemValues values = values_of(output);
  for (const auto& [name, number] : wanted.numbers) values.numbers[name] = number;
  for (const auto& [name, word] : wanted.words) values.words[name] = word;
  OutputScanConfig config = output.config;
  for (const OutputItem& item : output.items) {
    if (std::string complaint = take(item, values, config); !complaint.empty()) return complaint;
  }
  if (std::string complaint = conflict(config, output); !complaint.empty()) return complaint;
  output.config = config;
  return {};
}

std::size_t beams_of(const OutputScanConfig& config) {
  const auto grid = make_grid(config.grid);
  return grid ? grid->beams : 0;
}

}  // namespace lidard
