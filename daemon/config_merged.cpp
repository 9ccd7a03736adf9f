// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "daemon/config_output_keys.h"

namespace lidard {
namespace {

Sources read_sources(Mapping& yaml, const Config& config, const std::string& owner, ConfigClaims& claims,
                     std::vector<std::string>& names) {
  const std::string expected = "names of sensors that give scans: " + names_of(config, FrameKind::scan);
  const Value list = yaml.require("laserscan_topics", expected);
  Sources sources;
  for (const Value& value : list.names(expected)) {
    const SensorConfig& sensor = read_source(value, FrameKind::scan, config, owner, claims);
    if (std::find(names.begin(), names.end(), sensor.name) != names.end())
      value.fail("names " + sensor.name + " again", "every sensor once");
    names.push_back(sensor.name);
    sources.push_back(&sensor);
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
  const auto cloud = yaml.find("cloud_destination_topic");
  if (!cloud || cloud->text_or_empty().empty()) return;
  merged.cloud_destination_topic = read_topic(*cloud);
  claims.publishes(merged.cloud_destination_topic, owner, *cloud);
}

MergedScanConfig read_merged(const std::string& name, const Value& entry, Config& config,
                             ConfigClaims& claims) {
  Mapping yaml(entry,
               with_output_keys({"laserscan_topics", "destination_frame", "destination_pose",
                                 "scan_destination_topic", "cloud_destination_topic", "lost_after", "also",
                                 "echoes", "veil_filter", "fuse", "range_noise", "free_required"}));
  MergedScanConfig merged;
  merged.name = name;
  const Sources sources = read_sources(yaml, config, entry.path(), claims, merged.laserscan_topics);
  read_destination(yaml, config, entry.path(), claims, merged);
  read_merged_topics(yaml, entry.path(), claims, merged);
  if (const auto lost = yaml.find("lost_after")) merged.lost_after = lost->duration(0.001, longest_period_s);
  read_output(yaml, sources, true, config, merged.output);
  read_sight(yaml, entry.path(), config, claims, merged);
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
