// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config/config.h"

#include <algorithm>
#include <set>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "daemon/config/sections.h"
#include "daemon/config/yaml_reader.h"

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

void write(YAML::Emitter& yaml, const VehicleConfig& vehicle) { write_keys(yaml, vehicle_keys(), vehicle); }
void write(YAML::Emitter& yaml, const SensorConfig& sensor) {
  for (const SensorGroup& group : sensor_groups()) {
    if (takes(sensor, group)) write_keys(yaml, group.keys, sensor);
  }
}
void write(YAML::Emitter& yaml, const MergedScanConfig& merged) { write_keys(yaml, merged_keys(), merged); }
void write(YAML::Emitter& yaml, const MergedCloudConfig& merged) {
  write_keys(yaml, merged_cloud_keys(), merged);
}
void write(YAML::Emitter& yaml, const VirtualScanConfig& group) { write_keys(yaml, virtual_keys(), group); }

/// Writes named structures; a section that nothing stands in is left out.
template <class Entries>
void write_named(YAML::Emitter& yaml, const char* key, const Entries& entries) {
  if (entries.empty()) return;
  yaml << YAML::Key << key << YAML::Value << YAML::BeginMap;
  for (const auto& entry : entries) {
    yaml << YAML::Key << entry.name << YAML::Value << YAML::BeginMap;
    write(yaml, entry);
    yaml << YAML::EndMap;
  }
  yaml << YAML::EndMap;
}

void add_merged(const MergedScanConfig& merged, std::vector<OutputTopic>& topics) {
  topics.push_back({merged.scan_destination_topic, TopicKind::scan});
  if (!merged.status_topic.empty()) topics.push_back({merged.status_topic, TopicKind::scan});
  for (const auto& also : merged.also) topics.push_back({also.topic, TopicKind::scan});
  if (!merged.cloud_destination_topic.empty())
    topics.push_back({merged.cloud_destination_topic, TopicKind::cloud});
}

void add_virtual(const VirtualScanConfig& group, std::vector<OutputTopic>& topics) {
  for (const auto& frame : group.virtual_laser_scan) {
    topics.push_back({group.topic(frame), TopicKind::scan});
    for (const auto& also : group.also) topics.push_back({group.topic(frame, &also), TopicKind::scan});
    if (!group.output_laser_topic.empty()) break;
  }
}

/// Topics of the device's messages beside its frames.
void add_device_topics(const SensorConfig& sensor, std::vector<OutputTopic>& topics) {
  const std::string below = sensor.name + "/";
  const bool states = !sensor.model->has(Trait::states_on_request) || sensor.driver.requests.device_states;
  for (const MessageTopic& message : sensor.model->messages) {
    if (message.kind == message_kind<DeviceState>() && !states) continue;
    if (message.name == output_paths_topic && !sensor.output_paths_topic.empty()) continue;
    topics.push_back(
        {below + std::string(message.name), TopicKind::message, false, message.kind, 0, message.name});
  }
  if (!states) return;
  for (const auto name : sensor.model->extra_scans)
    topics.push_back({below + std::string(name), TopicKind::scan, false, 0, 0, name});
}

}  // namespace

const SensorConfig* Config::find_sensor(const std::string& name) const {
  for (const SensorConfig& sensor : sensors) {
    if (sensor.name == name) return &sensor;
  }
  return nullptr;
}

std::vector<std::string> Config::lidars_of(const VirtualScanConfig& group) const {
  for (const MergedCloudConfig& merged : merged_clouds) {
    if (merged.destination_topic == group.cloud_topic) return merged.sources;
  }
  return {group.cloud_topic};
}

Config parse_config(const std::string& text, const std::string& name) {
  Reading reading;
  reading.config.file = name;
  const Value file = parse_yaml(text, name);
  Mistakes mistakes;
  Mapping root(file, {"vehicle", "sensors", "merged_scans", "merged_clouds", "virtual_scans", "blackbox"},
               &mistakes);
  reading.is_complete = root.is_complete();
  reading.is_vehicle_valid = mistakes.attempt([&] { read_vehicle(root, reading); });
  for (const auto read_part :
       {read_sensors, read_merged_clouds, read_virtual_scans, read_merged_scans, read_black_box})
    mistakes.attempt([&] { read_part(root, reading); });
  mistakes.throw_if_any();
  warn_of_unused(root, reading);
  add_remarks(file, reading);
  return std::move(reading.config);
}

std::string to_yaml(const Config& config) {
  YAML::Emitter yaml;
  yaml << YAML::BeginMap << YAML::Key << "vehicle" << YAML::Value << YAML::BeginMap;
  write(yaml, config.vehicle);
  yaml << YAML::EndMap;
  write_named(yaml, "sensors", config.sensors);
  write_named(yaml, "merged_scans", config.merged_scans);
  write_named(yaml, "merged_clouds", config.merged_clouds);
  write_named(yaml, "virtual_scans", config.virtual_scans);
  if (config.black_box.seconds > 0) {
    yaml << YAML::Key << "blackbox" << YAML::Value << YAML::BeginMap;
    write_keys(yaml, black_box_keys(), config.black_box);
    yaml << YAML::EndMap;
  }
  yaml << YAML::EndMap;
  return with_indented_comments(yaml.c_str());
}

bool operator==(const VehicleConfig& a, const VehicleConfig& b) { return same_keys(vehicle_keys(), a, b); }
bool operator==(const SensorConfig& a, const SensorConfig& b) {
  const auto same = [&](const SensorGroup& group) {
    return takes(a, group) == takes(b, group) && (!takes(a, group) || same_keys(group.keys, a, b));
  };
  const auto& groups = sensor_groups();
  // What another entry's profile asks of the driver counts too.
  return a.name == b.name && a.model == b.model && a.calibration_digest == b.calibration_digest &&
         a.driver.keep_too_near == b.driver.keep_too_near && std::all_of(groups.begin(), groups.end(), same);
}
bool operator==(const MergedScanConfig& a, const MergedScanConfig& b) {
  return a.name == b.name && same_keys(merged_keys(), a, b);
}
bool operator==(const MergedCloudConfig& a, const MergedCloudConfig& b) {
  return a.name == b.name && same_keys(merged_cloud_keys(), a, b);
}
bool operator==(const VirtualScanConfig& a, const VirtualScanConfig& b) {
  return a.name == b.name && same_keys(virtual_keys(), a, b);
}

std::string yaml_text(const KeyMap& keys) {
  YAML::Emitter yaml;
  write_tree(yaml, keys);
  return yaml.c_str() + std::string("\n");
}

Config load_config(const std::string& path) {
  return parse_config(read_file(path, "a readable YAML file"), path);
}

std::vector<Flow> flows_of(const SensorConfig& sensor) {
  if (sensor.model == nullptr) return {};
  std::vector<Flow> flows = flows_of(*sensor.model, sensor.ip_address.value_or(IpAddress()), sensor.ip_port,
                                     sensor.telemetry_port, sensor.device_port());
  const auto is_foreign = [&](const Flow& flow) {
    // Another node receives the datagrams; a connection identifies a device only by address.
    return flow.transport == Transport::udp ? !sensor.packet_topic.empty() : !sensor.ip_address;
  };
  flows.erase(std::remove_if(flows.begin(), flows.end(), is_foreign), flows.end());
  return flows;
}

OutputTopic frame_topic(const SensorConfig& sensor) {
  if (sensor.model != nullptr && sensor.model->kind == FrameKind::cloud)
    return {sensor.points_topic.empty() ? sensor.name + "/points" : sensor.points_topic, TopicKind::cloud};
  return {sensor.scan_topic.empty() ? sensor.name + "/scan" : sensor.scan_topic, TopicKind::scan};
}

std::vector<OutputTopic> sensor_topics(const SensorConfig& sensor) {
  std::vector<OutputTopic> topics;
  if (sensor.model == nullptr) return topics;
  topics.push_back(frame_topic(sensor));
  if (sensor.ring_scan) topics.push_back({sensor.scan_topic, TopicKind::scan});
  if (sensor.model->has(Trait::echoes) && sensor.driver.publish_multiecho)
    topics.push_back({sensor.name + "/echoes", TopicKind::echoes});
  if (!sensor.raw_topic.empty())
    topics.push_back({sensor.raw_topic, TopicKind::message, true, message_kind<RawPackets>()});
  if (!sensor.extended_scan_topic.empty())
    topics.push_back({sensor.extended_scan_topic, TopicKind::extended_scan});
  if (!sensor.output_paths_topic.empty())
    topics.push_back({sensor.output_paths_topic, TopicKind::output_paths, false, 0, 0, output_paths_topic});
  add_device_topics(sensor, topics);
  return topics;
}

std::vector<StaticTransform> fixed_poses(const Config& config) {
  std::vector<StaticTransform> poses;
  std::set<std::string> known;
  const auto add = [&](const std::string& parent, const std::string& child, const Pose& pose) {
    // A frame has one parent (REP 105); the first entry that names it counts.
    if (child != parent && known.insert(child).second) poses.push_back({parent, child, pose});
  };
  for (const StaticTransform& one : config.elsewhere.poses) add(one.parent, one.child, one.pose);
  const std::string& base = config.vehicle.base_frame;
  for (const SensorConfig& sensor : config.sensors) {
    if (sensor.pose) add(base, sensor.frame_id, *sensor.pose);
  }
  for (const MergedScanConfig& merged : config.merged_scans) {
    if (merged.destination_pose) add(base, merged.destination_frame, *merged.destination_pose);
  }
  for (const MergedCloudConfig& merged : config.merged_clouds) {
    if (merged.destination_pose) add(base, merged.destination_frame, *merged.destination_pose);
  }
  for (const VirtualScanConfig& group : config.virtual_scans) {
    for (const auto& [frame, pose] : group.poses) add(group.base_frame, frame, pose);
  }
  return poses;
}

std::vector<OutputTopic> output_topics(const Config& config) {
  std::vector<OutputTopic> topics;
  for (const auto& sensor : config.sensors) {
    for (auto& topic : sensor_topics(sensor)) topics.push_back(std::move(topic));
  }
  for (const auto& merged : config.merged_scans) add_merged(merged, topics);
  for (const auto& merged : config.merged_clouds)
    topics.push_back({merged.destination_topic, TopicKind::merged_cloud});
  for (const auto& group : config.virtual_scans) add_virtual(group, topics);
  for (std::size_t id = 0; id < topics.size(); ++id) topics[id].id = id;
  return topics;
}

}  // namespace lidard
