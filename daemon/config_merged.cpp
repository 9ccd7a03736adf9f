// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "daemon/config_output_keys.h"

namespace lidard {
namespace {

/// The topics of virtual scans, each of one frame.
std::vector<std::pair<std::string, const VirtualScanConfig*>> virtual_topics(const Config& config) {
  std::vector<std::pair<std::string, const VirtualScanConfig*>> topics;
  for (const VirtualScanConfig& group : config.virtual_scans) {
    if (group.output_laser_topic.empty())
      for (const std::string& frame : group.virtual_laser_scan) topics.emplace_back(frame, &group);
    else if (group.virtual_laser_scan.size() == 1)
      topics.emplace_back(group.output_laser_topic, &group);
  }
  return topics;
}

std::string without_slash(const std::string& topic) {
  return !topic.empty() && topic.front() == '/' ? topic.substr(1) : topic;
}

/// The virtual scan that a source names by its topic, and the topic as it is published; nullptr if it names
/// none, or a sensor.
std::pair<std::string, const VirtualScanConfig*> find_virtual(const Config& config, const std::string& name) {
  if (config.find_sensor(name) != nullptr) return {};
  for (const auto& one : virtual_topics(config)) {
    if (without_slash(one.first) == without_slash(name)) return one;
  }
  return {};
}

Sources read_sources(Mapping& yaml, const Config& config, const std::string& owner, ConfigClaims& claims,
                     std::vector<std::string>& names) {
  std::string expected = "names of sensors that give scans: " + names_of(config, FrameKind::scan);
  const auto virtuals = virtual_topics(config);
  for (const auto& [topic, group] : virtuals)
    expected += (group == virtuals.front().second && topic == virtuals.front().first ? "; or virtual scans: "
                                                                                     : ", ") +
                topic;
  const Value list = yaml.require("laserscan_topics", expected);
  Sources sources;
  for (const Value& value : list.names(expected)) {
    if (const auto [topic, group] = find_virtual(config, value.text(expected)); group != nullptr) {
      if (std::find(names.begin(), names.end(), topic) != names.end())
        value.fail("names " + topic + " again", "every source once");
      names.push_back(topic);
      sources.emplace_back(group->output.grid);
      continue;
    }
    const SensorConfig& sensor = read_source(value, FrameKind::scan, config, owner, claims);
    if (std::find(names.begin(), names.end(), sensor.name) != names.end())
      value.fail("names " + sensor.name + " again", "every sensor once");
    names.push_back(sensor.name);
    sources.emplace_back(&sensor);
  }
  if (sources.empty()) list.fail("names nothing", expected);
  return sources;
}

void read_destination(Mapping& yaml, const Config& config, const std::string& owner, ConfigClaims& claims,
                      MergedScanConfig& merged) {
  const std::string& base = config.vehicle.base_frame;
  const auto frame = yaml.find("destination_frame");
  merged.destination_frame = frame ? read_frame(*frame) : base;
  if (const auto pose = yaml.find("destination_pose")) {
    merged.destination_pose = read_pose(*pose);
    claims.holds_frame(merged.destination_frame, base, *merged.destination_pose, owner, *pose);
  } else if (merged.destination_frame == base) {
    merged.destination_pose = Pose::Identity();
  }
}

void read_merged_topics(Mapping& yaml, const std::string& owner, ConfigClaims& claims,
                        MergedScanConfig& merged) {
  const auto scan = yaml.find("scan_destination_topic");
  merged.scan_destination_topic = scan ? read_topic(*scan) : merged.name;
  claims.publishes(merged.scan_destination_topic, owner, scan ? *scan : yaml.self());
  const auto status = yaml.find("status_topic");
  if (status && !status->text_or_empty().empty()) {
    merged.status_topic = read_topic(*status);
    claims.publishes(merged.status_topic, owner, *status);
  }
  const auto cloud = yaml.find("cloud_destination_topic");
  if (!cloud || cloud->text_or_empty().empty()) return;
  merged.cloud_destination_topic = read_topic(*cloud);
  claims.publishes(merged.cloud_destination_topic, owner, *cloud);
}

/// Points alone prove nothing, so they are no evidence for what is free or hidden.
void refuse_flat_sources(Mapping& yaml, const Config& config, const MergedScanConfig& merged) {
  if (!merged.has_sight()) return;
  for (const Value& value : yaml.where("laserscan_topics").names("names")) {
    const VirtualScanConfig* group = find_virtual(config, value.text()).second;
    if (group != nullptr && group->output.profile == Profile::flatten)
      value.fail("names " + value.quoted() + ", a virtual scan of profile flatten, which proves nothing",
                 "a virtual scan of profile strict or safety, or profile: flatten here");
  }
}

MergedScanConfig read_merged(const std::string& name, const Value& entry, Config& config,
                             ConfigClaims& claims) {
  std::vector<std::string_view> keys = {"laserscan_topics",
                                        "destination_frame",
                                        "destination_pose",
                                        "scan_destination_topic",
                                        "cloud_destination_topic",
                                        "status_topic",
                                        "also",
                                        "echoes",
                                        "veil_filter",
                                        "fuse",
                                        "range_noise",
                                        "free_required",
                                        "conflicts",
                                        "free_requires",
                                        "veil_cross_check",
                                        "intensity",
                                        "missing_intensity"};
  keys.insert(keys.end(), schedule_keys.begin(), schedule_keys.end());
  Mapping yaml(entry, with_output_keys(std::move(keys)));
  MergedScanConfig merged;
  merged.name = name;
  const Sources sources = read_sources(yaml, config, entry.path(), claims, merged.laserscan_topics);
  read_destination(yaml, config, entry.path(), claims, merged);
  read_merged_topics(yaml, entry.path(), claims, merged);
  read_output(yaml, sources, config, merged.output);
  read_sight(yaml, entry.path(), config, claims, merged);
  read_merge_options(yaml, merged);
  refuse_flat_sources(yaml, config, merged);
  read_schedule(yaml, merged);
  read_source_settings(yaml, merged);
  return merged;
}

}  // namespace

void read_merged_scans(Mapping& root, Config& config, ConfigClaims& claims) {
  const auto section = root.find("merged_scans");
  if (!section) return;
  for (const auto& [name, entry] : named_entries(*section)) {
    check_entry_name(name, entry);
    config.merged_scans.push_back(read_merged(name, entry, config, claims));
  }
}

}  // namespace lidard
