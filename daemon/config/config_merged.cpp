// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "daemon/config/config_output_keys.h"
#include "daemon/config/config_sources.h"

namespace lidard {
namespace {

/// The sources of a merged scan.
struct ReadSources {
  Sources limits;
  std::vector<NamedSource> named;
  std::vector<Value> values;  // as written
};

std::string expected_sources(const Config& config) {
  std::string expected = "names of sensors that give scans: " + names_of(config, FrameKind::scan);
  const char* separator = "; or virtual scans: ";
  for (const std::string& topic : virtual_topics(config)) {
    expected += separator + topic;
    separator = ", ";
  }
  return expected;
}

ReadSources read_sources(Mapping& yaml, const Config& config, const std::string& owner, ConfigClaims& claims,
                         std::vector<std::string>& names) {
  const std::string expected = expected_sources(config);
  const Value list = yaml.require("laserscan_topics", expected);
  ReadSources sources;
  for (const Value& value : list.names(expected)) {
    const NamedSource source = read_source(value, FrameKind::scan, config, expected);
    const bool sensor = source.sensor != nullptr;
    if (std::find(names.begin(), names.end(), source.name) != names.end())
      value.fail("names " + source.name + " again", sensor ? "every sensor once" : "every source once");
    if (sensor) claims.uses(*source.sensor, FrameKind::scan, owner, value);
    names.push_back(source.name);
    sources.limits.push_back(sensor ? SourceLimits(source.sensor) : source.virtual_group->output.grid);
    sources.named.push_back(source);
    sources.values.push_back(value);
  }
  if (names.empty()) list.fail("names nothing", expected);
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
void refuse_flat_sources(const ReadSources& sources, const MergedScanConfig& merged) {
  if (!merged.has_visibility()) return;
  for (std::size_t i = 0; i < sources.named.size(); ++i) {
    const VirtualScanConfig* group = sources.named[i].virtual_group;
    const Value& value = sources.values[i];
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
  const ReadSources sources = read_sources(yaml, config, entry.path(), claims, merged.laserscan_topics);
  read_destination(yaml, config, entry.path(), claims, merged);
  read_merged_topics(yaml, entry.path(), claims, merged);
  read_output(yaml, sources.limits, config, merged.output);
  read_visibility(yaml, entry.path(), config, claims, merged);
  read_merge_options(yaml, merged);
  refuse_flat_sources(sources, merged);
  std::vector<std::string> written;
  for (const Value& value : sources.values) written.push_back(value.text());
  read_schedule(yaml, written, merged);
  read_source_settings(yaml, written, merged);
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
