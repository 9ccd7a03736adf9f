// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "daemon/config/config_cut.h"
#include "daemon/config/config_output_keys.h"
#include "daemon/config/config_sources.h"

namespace lidard {
namespace {

// ira_laser_tools' first release kept what lay within 0.1 m of the plane; later ones 1 cm, then everything.
constexpr double virtual_half_height_m = 0.1;

void read_frames(Mapping& yaml, VirtualScanConfig& scan) {
  const std::string expected = "names of frames, each the origin of one virtual scan";
  const Value list = yaml.require("virtual_laser_scan", expected);
  for (const Value& value : list.names(expected)) {
    const std::string frame = read_frame(value);
    const auto& known = scan.virtual_laser_scan;
    if (std::find(known.begin(), known.end(), frame) != known.end())
      value.fail("names " + frame + " again", "every frame once");
    scan.virtual_laser_scan.push_back(frame);
  }
  if (scan.virtual_laser_scan.empty()) list.fail("names nothing", expected);
}

void read_poses(Mapping& yaml, const std::string& owner, ConfigClaims& claims, VirtualScanConfig& scan) {
  const std::vector<std::string_view> frames(scan.virtual_laser_scan.begin(), scan.virtual_laser_scan.end());
  if (std::find(frames.begin(), frames.end(), scan.base_frame) != frames.end())
    scan.poses[scan.base_frame] = Pose::Identity();
  const auto section = yaml.find("poses");
  if (!section) return;
  Mapping poses(*section, frames);
  for (const std::string_view frame : frames) {
    const auto value = poses.find(frame);
    if (!value) continue;
    const Pose pose = read_pose(*value);
    claims.holds_frame(std::string(frame), scan.base_frame, pose, owner, *value);
    scan.poses[std::string(frame)] = pose;
  }
}

void read_virtual_topics(Mapping& yaml, const std::string& owner, Config& config, ConfigClaims& claims,
                         VirtualScanConfig& scan) {
  const auto topic = yaml.find("output_laser_topic");
  if (!topic || topic->text_or_empty().empty()) {
    for (const Value& frame : yaml.where("virtual_laser_scan").names("names of frames"))
      claims.publishes(read_topic(frame), owner, frame);
    return;
  }
  scan.output_laser_topic = read_topic(*topic);
  claims.publishes(scan.output_laser_topic, owner, *topic);
  if (scan.virtual_laser_scan.size() > 1)
    warn(config, topic->place(),
         topic->path() + " carries scans of " + std::to_string(scan.virtual_laser_scan.size()) +
             " frames; leave it empty for one topic per frame");
}

VirtualScanConfig read_virtual(const std::string& name, const Value& entry, Config& config,
                               ConfigClaims& claims) {
  std::vector<std::string_view> keys = {"cloud_topic", "base_frame", "virtual_laser_scan", "poses",
                                        "output_laser_topic"};
  keys.insert(keys.end(), cut_keys.begin(), cut_keys.end());
  Mapping yaml(entry, with_output_keys(std::move(keys)));
  VirtualScanConfig scan;
  scan.name = name;
  const std::string expected = "a sensor that gives clouds: " + names_of(config, FrameKind::cloud);
  const Value named = yaml.require("cloud_topic", expected);
  const SensorConfig& source = *read_source(named, FrameKind::cloud, config, expected).sensor;
  claims.uses(source, FrameKind::cloud, entry.path(), named);
  scan.cloud_topic = source.name;
  const auto base = yaml.find("base_frame");
  scan.base_frame = base ? read_frame(*base) : config.vehicle.base_frame;
  read_frames(yaml, scan);
  read_poses(yaml, entry.path(), claims, scan);
  read_virtual_topics(yaml, entry.path(), config, claims, scan);
  scan.output.min_height = -virtual_half_height_m;
  scan.output.max_height = virtual_half_height_m;
  read_output(yaml, {&source}, config, scan.output);
  read_cut(yaml, source, entry.path(), config, claims, scan);
  return scan;
}

}  // namespace

void read_virtual_scans(Mapping& root, Config& config, ConfigClaims& claims) {
  const auto section = root.find("virtual_scans");
  if (!section) return;
  for (const auto& [name, entry] : named_entries(*section)) {
    check_entry_name(name, entry);
    config.virtual_scans.push_back(read_virtual(name, entry, config, claims));
  }
}

}  // namespace lidard
