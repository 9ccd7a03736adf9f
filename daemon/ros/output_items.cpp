// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/output_items.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/base/angle.h"
#include "core/base/number_text.h"
#include "daemon/config/config_parts.h"
#include "daemon/config/grid_limits.h"

namespace lidard {
namespace {

/// As far as configurations go; a height at this limit is none.
constexpr double farthest_m = 10000;
constexpr double longest_period_s = 3600;

constexpr Profile profiles[] = {Profile::strict, Profile::safety, Profile::flatten};
constexpr EmptyBeam beams[] = {EmptyBeam::inf, EmptyBeam::nan, EmptyBeam::range_max_plus_one,
                               EmptyBeam::minus_inf, EmptyBeam::zero};

template <class Choices>
std::vector<std::string> words_for(const Choices& choices) {
  std::vector<std::string> words;
  for (const auto choice : choices) words.emplace_back(word_of(choice));
  return words;
}

template <class Choices, class Choice>
bool choose(const Choices& choices, const std::string& word, Choice& choice) {
  for (const auto one : choices) {
    if (word != word_of(one)) continue;
    choice = one;
    return true;
  }
  return false;
}

std::vector<OutputItem> ancestor_items() {
  std::vector<OutputItem> items;
  for (const GridLimit& limit : grid_limits)
    items.push_back({limit.name, limit.meaning, limit.min, limit.max, {}});
  return items;
}

void widen(std::vector<OutputItem>& items, const std::string& name, double min, double max) {
  for (OutputItem& item : items) {
    if (item.name == name) item.min = min, item.max = max;
  }
}

std::vector<OutputItem> items_of(OutputId::Kind kind, ReconfigureNames names) {
  std::vector<OutputItem> items = ancestor_items();
  if (names == ReconfigureNames::node) return items;
  // What a configuration may hold must lie within the limits here.
  for (const char* angle : {"angle_min", "angle_max"}) widen(items, angle, -two_pi, two_pi);
  for (const char* range : {"range_min", "range_max"}) widen(items, range, 0, farthest_m);
  for (const char* time : {"time_increment", "scan_time"}) widen(items, time, 0, longest_period_s);
  items.push_back({"min_height", "m in the output frame; -10000: none", -farthest_m, farthest_m, {}});
  items.push_back({"max_height", "m in the output frame; 10000: none", -farthest_m, farthest_m, {}});
  if (kind == OutputId::Kind::merged)
    items.push_back({"profile", "how the scan says what is known", 0, 0, words_for(profiles)});
  items.push_back({"empty", "what stands where nothing is", 0, 0, words_for(beams)});
  items.push_back({"unobserved", "what stands where nothing is known", 0, 0, words_for(beams)});
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

double increment_of(const OutputScanConfig& config) {
  const auto grid = make_grid(config.grid);
  return config.grid.angle_increment.value_or(grid ? grid->increment : 0);
}

/// One item of a request, checked and brought into its limits; empty, or what is wrong.
std::string take(const OutputItem& item, const ItemValues& wanted, ItemValues& values) {
  const auto number = wanted.numbers.find(item.name);
  if (item.words.empty() && number != wanted.numbers.end()) {
    if (std::isnan(number->second)) return item.name + " is not a number; expected one";
    values.numbers[item.name] = std::clamp(number->second, item.min, item.max);
  }
  const auto word = wanted.words.find(item.name);
  if (item.words.empty() || word == wanted.words.end()) return {};
  if (std::find(item.words.begin(), item.words.end(), word->second) == item.words.end()) {
    std::string expected;
    for (const auto& one : item.words) expected += (expected.empty() ? "" : ", ") + one;
    return item.name + " is '" + word->second + "'; expected one of " + expected;
  }
  values.words[item.name] = word->second;
  return {};
}

void put(const ItemValues& values, OutputScanConfig& config) {
  ScanGridSpec& grid = config.grid;
  const auto number = [&](const char* name) { return values.numbers.at(name); };
  grid.angle_min = number("angle_min");
  grid.angle_max = number("angle_max");
  grid.angle_increment = number("angle_increment");
  grid.beams.reset();
  grid.time_increment = number("time_increment");
  grid.scan_time = number("scan_time");
  grid.range_min = number("range_min");
  grid.range_max = number("range_max");
  if (const double height = number("min_height"); height > -farthest_m)
    config.min_height = height;
  else
    config.min_height.reset();
  if (const double height = number("max_height"); height < farthest_m)
    config.max_height = height;
  else
    config.max_height.reset();
  choose(profiles, values.words.at("profile"), config.profile);
  choose(beams, values.words.at("empty"), config.empty);
  choose(beams, values.words.at("unobserved"), config.unobserved);
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
  const OutputScanConfig& config = output.config;
  const ScanGridSpec& grid = config.grid;
  ItemValues values;
  values.numbers = {{"angle_min", grid.angle_min},
                    {"angle_max", grid.angle_max},
                    {"angle_increment", increment_of(config)},
                    {"time_increment", grid.time_increment},
                    {"scan_time", grid.scan_time},
                    {"range_min", grid.range_min},
                    {"range_max", grid.range_max},
                    {"min_height", config.min_height.value_or(-farthest_m)},
                    {"max_height", config.max_height.value_or(farthest_m)}};
  values.words = {{"profile", word_of(config.profile)},
                  {"empty", word_of(config.empty)},
                  {"unobserved", word_of(config.unobserved)}};
  return values;
}

std::string change(ChangeableOutput& output, const ItemValues& wanted) {
  ItemValues values = values_of(output);
  for (const OutputItem& item : output.items) {
    if (std::string complaint = take(item, wanted, values); !complaint.empty()) return complaint;
  }
  OutputScanConfig config = output.config;
  put(values, config);
  if (std::string complaint = conflict(config, output); !complaint.empty()) return complaint;
  output.config = config;
  return {};
}

std::size_t beams_of(const OutputScanConfig& config) {
  const auto grid = make_grid(config.grid);
  return grid ? grid->beams : 0;
}

}  // namespace lidard
