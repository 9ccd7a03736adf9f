// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config/config.h"

#include <sstream>

#include "daemon/config/read_file.h"
#include "daemon/config/sections.h"

namespace lidard {
namespace {

void warn_of_unused(Mapping& root, Reading& reading) {
  Value section = *root.find("sensors");
  for (const auto& [name, entry] : named_entries(section)) {
    const SensorConfig* sensor = reading.config.find_sensor(name);
    if (sensor->model == nullptr && !reading.claims.is_used(name))
      reading.warn(entry.key_place(), entry.path() + " is used by no merged and no virtual scan");
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

/// Writes named structures; a section that nothing stands in is left out.
template <class Entries, class WriteOne>
void write_named(YAML::Emitter& yaml, const char* key, const Entries& entries, const WriteOne& write_one) {
  if (entries.empty()) return;
  yaml << YAML::Key << key << YAML::Value << YAML::BeginMap;
  for (const auto& entry : entries) {
    yaml << YAML::Key << entry.name << YAML::Value << YAML::BeginMap;
    write_one(entry);
    yaml << YAML::EndMap;
  }
  yaml << YAML::EndMap;
}

}  // namespace

const SensorConfig* Config::find_sensor(const std::string& name) const {
  for (const SensorConfig& sensor : sensors) {
    if (sensor.name == name) return &sensor;
  }
  return nullptr;
}

Config parse_config(const std::string& text, const std::string& name) {
  Reading reading;
  reading.config.file = name;
  const Value file = parse_yaml(text, name);
  reading.mistakes.attempt(file.place(), [&] {
    Mapping root(file, {"vehicle", "sensors", "merged_scans", "virtual_scans"}, reading.mistakes);
    read_vehicle(root, reading);
    read_sensors(root, reading);
    read_virtual_scans(root, reading);
    read_merged_scans(root, reading);
    if (reading.mistakes.count() == 0) warn_of_unused(root, reading);
  });
  reading.mistakes.throw_if_any();
  return std::move(reading.config);
}

std::string to_yaml(const Config& config) {
  YAML::Emitter yaml;
  yaml << YAML::BeginMap << YAML::Key << "vehicle" << YAML::Value << YAML::BeginMap;
  write_keys(yaml, vehicle_keys(), config.vehicle);
  yaml << YAML::EndMap;
  write_named(yaml, "sensors", config.sensors, [&](const SensorConfig& sensor) {
    for (const SensorGroup& group : sensor_groups()) {
      if (takes(sensor, group)) write_keys(yaml, group.keys, sensor);
    }
  });
  write_named(yaml, "merged_scans", config.merged_scans,
              [&](const auto& scan) { write_keys(yaml, merged_keys(), scan); });
  write_named(yaml, "virtual_scans", config.virtual_scans,
              [&](const auto& scan) { write_keys(yaml, virtual_keys(), scan); });
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
