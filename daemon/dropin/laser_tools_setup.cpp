// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/dropin/laser_tools_setup.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cctype>
#include <set>
#include <sstream>

#include "core/base/number_text.h"
#include "daemon/config/config_parts.h"
#include "daemon/config/grid_limits.h"
#include "daemon/dropin/parameter_reader.h"

namespace lidard {
namespace {

/// Keys of our own configuration that may be given as parameters too.
constexpr const char* our_output_keys[] = {"profile", "unobserved", "min_height", "max_height"};
constexpr const char* our_merged_keys[] = {"echoes",      "veil_filter",      "fuse",
                                           "range_noise", "free_required",    "status_topic",
                                           "conflicts",   "free_requires",    "veil_cross_check",
                                           "intensity",   "missing_intensity"};
/// Read by laserscan_virtualizer from absolute names.
constexpr const char* absolute_keys[] = {"base_frame", "cloud_topic", "output_laser_topic",
                                         "virtual_laser_scan"};

using Warnings = std::vector<std::string>;

/// The words of a list, each once, in their order.
std::vector<std::string> words_of(const std::string& list) {
  std::vector<std::string> words;
  std::istringstream stream(list);
  for (std::string word; stream >> word;) {
    if (std::find(words.begin(), words.end(), word) == words.end()) words.push_back(word);
  }
  return words;
}

/// A topic as the name of an entry in a configuration, other than those in `taken`.
std::string entry_name(const std::string& topic, std::set<std::string>& taken) {
  std::string name;
  for (const char c : topic) {
    const bool word = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
    if (word || !name.empty()) name += word ? c : '_';
  }
  if (name.empty() || std::isalpha(static_cast<unsigned char>(name.front())) == 0) name.insert(0, "scan_");
  std::string unique = name;
  for (int n = 2; !taken.insert(unique).second; ++n) unique = name + "_" + std::to_string(n);
  return unique;
}

class Writer {
 public:
  void open(const std::string& name) { yaml_ << YAML::Key << name << YAML::Value << YAML::BeginMap; }
  void close() { yaml_ << YAML::EndMap; }
  void text(const std::string& key, const std::string& value) {
    yaml_ << YAML::Key << key << YAML::Value << value;
  }
  void list(const std::string& key, const std::vector<std::string>& values) {
    yaml_ << YAML::Key << key << YAML::Value << YAML::Flow << values;
  }
  std::string finish() {
    yaml_ << YAML::EndMap;
    return yaml_.c_str() + std::string("\n");
  }
  Writer() { yaml_ << YAML::BeginMap; }

 private:
  YAML::Emitter yaml_;
};

/// The grid, each number brought into its limits as dynamic_reconfigure does; what is left must make sense.
ScanGridSpec read_grid(ParameterReader& reader, Warnings& warnings) {
  ScanGridSpec grid;
  double increment = 0;
  double* const places[] = {&grid.angle_min, &grid.angle_max, &increment,     &grid.time_increment,
                            &grid.scan_time, &grid.range_min, &grid.range_max};
  for (std::size_t i = 0; i < grid_limits.size(); ++i) {
    const GridLimit& limit = grid_limits[i];
    const double given = reader.number(limit.name, limit.preset);
    *places[i] = std::clamp(given, limit.min, limit.max);
    if (*places[i] != given)
      warnings.push_back("parameter ~" + std::string(limit.name) + " is " + number_text(given) +
                         "; the limit is " + number_text(*places[i]));
  }
  grid.angle_increment = increment;
  std::string complaint;
  if (!make_grid(grid, complaint)) throw ConfigError("private parameters: " + complaint);
  return grid;
}

void write_output(ParameterReader& reader, Writer& writer, Warnings& warnings) {
  const ScanGridSpec grid = read_grid(reader, warnings);
  const double values[] = {grid.angle_min, grid.angle_max, *grid.angle_increment, grid.time_increment,
                           grid.scan_time, grid.range_min, grid.range_max};
  for (std::size_t i = 0; i < grid_limits.size(); ++i)
    writer.text(grid_limits[i].name, number_text(values[i]));
  // What ira_laser_tools publishes where it saw nothing.
  writer.text("empty", reader.text("empty", "range_max_plus_one"));
  for (const char* key : our_output_keys) {
    if (const auto value = reader.find(key)) writer.text(key, *value);
  }
}

void write_base(Writer& writer, const std::string& frame) {
  writer.open("vehicle");
  writer.text("base_frame", frame);
  writer.close();
}

/// The topics as sensors; their names, none of which is the topic of another.
std::vector<std::string> write_sensors(Writer& writer, const std::vector<std::string>& topics) {
  std::vector<std::string> names;
  writer.open("sensors");
  for (const std::string& topic : topics) {
    std::set<std::string> taken(names.begin(), names.end());
    for (const std::string& other : topics) {
      if (other != topic) taken.insert(other.front() == '/' ? other.substr(1) : other);
    }
    names.push_back(entry_name(topic, taken));
    writer.open(names.back());
    writer.text("topic", topic);
    writer.close();
  }
  writer.close();
  return names;
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
  std::set<std::string> none;
  Writer writer;
  write_base(writer, frame);
  const auto names = write_sensors(writer, topics);
  writer.open("merged_scans");
  writer.open(entry_name(scan_topic, none));
  writer.list("laserscan_topics", names);
  writer.text("destination_frame", frame);
  writer.text("scan_destination_topic", scan_topic);
  writer.text("cloud_destination_topic", reader.text("cloud_destination_topic", "/merged_cloud"));
  write_output(reader, writer, setup.warnings);
  for (const char* key : our_merged_keys) {
    if (const auto value = reader.find(key)) writer.text(key, *value);
  }
  for (const std::string_view key : schedule_keys) {
    if (const auto value = reader.find(std::string(key))) writer.text(std::string(key), *value);
  }
  writer.close();
  writer.close();
  setup.yaml = writer.finish();
  reader.remark_on_rest(setup.warnings);
  return setup;
}

DropinSetup laser_virtualizer_setup(const NodeParameters& parameters) {
  DropinSetup setup;
  ParameterReader reader(parameters);
  const auto frames = required_words(reader, "virtual_laser_scan", "frames");
  const std::string base = reader.text("base_frame", "/cart_frame");
  Writer writer;
  write_base(writer, base);
  const auto names = write_sensors(writer, {reader.text("cloud_topic", "/cloud_pcd")});
  writer.open("virtual_scans");
  writer.open("virtual_laser_scan");
  writer.text("cloud_topic", names.front());
  writer.text("base_frame", base);
  writer.list("virtual_laser_scan", frames);
  writer.text("output_laser_topic", reader.text("output_laser_topic", ""));
  write_output(reader, writer, setup.warnings);
  writer.close();
  writer.close();
  setup.yaml = writer.finish();
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
