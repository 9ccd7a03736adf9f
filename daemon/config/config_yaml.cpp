// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// A configuration as YAML.
#include <yaml-cpp/yaml.h>

#include <sstream>

#include "daemon/config/config.h"
#include "daemon/config/reading.h"
#include "daemon/config/rows.h"
#include "daemon/config/values.h"
#include "daemon/yaml/yaml.h"

namespace lidard {
namespace {

void warn_of_unused(const Mapping& root, Reading& reading) {
  for (const auto& [name, entry] : root.find("sensors")->entries()) {
    const SensorConfig* const sensor = find_sensor(reading.sensors, name);
    if (sensor->model == nullptr && !reading.claims.is_used(name))
      reading.warn(entry.key_location(), entry.path() + " is used by no merged and no virtual scan");
  }
}

/// yaml-cpp begins comments at the margin; each belongs to the mapping of the line above it.
std::string with_indented_comments(const std::string& yaml) {
  std::istringstream lines(yaml);
  std::string result;
  std::string indent;
  for (std::string line; std::getline(lines, line);) {
    if (!line.empty() && line.front() == '#')
      line.insert(0, indent);
    else
      indent = line.substr(0, line.find_first_not_of(' '));
    result += line + '\n';
  }
  return result;
}

template <class Section>
void write_section(YAML::Emitter& yaml, const std::string& name, Keys (*keys)(Section&), Section section) {
  yaml << YAML::Key << name << YAML::Value << YAML::BeginMap;
  write_keys(yaml, keys(section));
  yaml << YAML::EndMap;
}

/// Writes named structures; a section that nothing stands in is left out.
template <class Entry>
void write_named(YAML::Emitter& yaml, const char* section, Keys (*keys)(Entry&),
                 const std::vector<Entry>& entries) {
  if (entries.empty()) return;
  yaml << YAML::Key << section << YAML::Value << YAML::BeginMap;
  for (const Entry& entry : entries) write_section(yaml, entry.name, keys, entry);
  yaml << YAML::EndMap;
}

}  // namespace

Config parse_config(const std::string& text, const std::string& name) {
  Config config;
  config.file = name;
  config.text = text;
  Reading reading{config.file,    config.warnings,      config.vehicle,
                  config.sensors, config.merged_clouds, config.virtual_scans};
  const Value file = parse_yaml(text, name);
  Mistakes mistakes;
  const Mapping root = known_mapping(
      file, {"vehicle", "sensors", "merged_scans", "merged_clouds", "virtual_scans", "blackbox"}, mistakes);
  reading.is_complete = root.is_complete();
  reading.is_vehicle_valid = mistakes.attempt([&] { read_vehicle(root, reading); });
  mistakes.attempt([&] { read_sensors(root, reading); });
  mistakes.attempt([&] { read_merged_clouds(root, reading); });
  mistakes.attempt([&] { read_virtual_scans(root, reading); });
  mistakes.attempt([&] { read_merged_scans(root, config.merged_scans, reading); });
  mistakes.attempt([&] { read_black_box(root, config.black_box); });
  mistakes.throw_if_any();
  warn_of_unused(root, reading);
  return config;
}

std::string to_yaml(const Config& config) {
  YAML::Emitter yaml;
  yaml << YAML::BeginMap;
  write_section(yaml, "vehicle", vehicle_keys, config.vehicle);
  write_named(yaml, "sensors", sensor_keys, config.sensors);
  write_named(yaml, "merged_scans", merged_keys, config.merged_scans);
  write_named(yaml, "merged_clouds", merged_cloud_keys, config.merged_clouds);
  write_named(yaml, "virtual_scans", virtual_keys, config.virtual_scans);
  if (config.black_box.seconds > 0) write_section(yaml, "blackbox", black_box_keys, config.black_box);
  yaml << YAML::EndMap;
  return with_indented_comments(yaml.c_str());
}

std::string yaml_text(const KeyMap& keys) {
  YAML::Emitter yaml;
  write_tree(yaml, keys);
  return yaml.c_str() + std::string("\n");
}

Config load_config(const std::string& path) {
  return parse_config(read_file(path, "a readable YAML file"), path);
}

}  // namespace lidard
