// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <set>

#include "core/nearest.h"
#include "daemon/config_parts.h"

namespace lidard {
namespace {

constexpr double farthest_m = 10000;
constexpr double longest_period_s = 3600;
// ira_laser_tools' first release kept what lay within 0.1 m of the plane; later ones 1 cm, then everything.
constexpr double virtual_half_height_m = 0.1;
constexpr std::size_t default_beams_per_turn = 1440;
constexpr long most_beams = 32767;

const std::vector<std::string_view> output_keys = {
    "profile",        "beams",         "empty",     "unobserved",    "min_height",      "max_height",
    "angle_min",      "angle_min_deg", "angle_max", "angle_max_deg", "angle_increment", "angle_increment_deg",
    "time_increment", "scan_time",     "range_min", "range_max"};

std::vector<std::string_view> with_output_keys(std::vector<std::string_view> keys) {
  keys.insert(keys.end(), output_keys.begin(), output_keys.end());
  return keys;
}

using Sources = std::vector<const SensorConfig*>;

std::string kind_of(const SensorConfig& sensor) {
  const bool cloud = sensor.model->kind == FrameKind::cloud;
  return std::string(sensor.model->name) + (cloud ? ", which gives clouds" : ", which gives scans");
}

bool can_give(const SensorConfig& sensor, FrameKind kind) {
  return sensor.model == nullptr || sensor.model->kind == kind;
}

std::string names_of(const Config& config, FrameKind kind) {
  std::string list;
  for (const SensorConfig& sensor : config.sensors) {
    if (can_give(sensor, kind)) list += (list.empty() ? "" : ", ") + sensor.name;
  }
  return list.empty() ? "none is configured" : list;
}

/// By its name in `sensors:`, or by a topic: the one it listens to or the one it publishes.
const SensorConfig* find_source(const Config& config, std::string name) {
  if (name.size() > 1 && name.front() == '/') name.erase(0, 1);
  for (const SensorConfig& sensor : config.sensors) {
    const bool listens = sensor.topic == name || sensor.topic == "/" + name;
    const bool publishes = name == sensor.name + "/scan" || name == sensor.name + "/points";
    if (sensor.name == name || (sensor.model == nullptr ? listens : publishes)) return &sensor;
  }
  return nullptr;
}

const SensorConfig& read_source(const Value& value, FrameKind kind, const Config& config,
                                const std::string& owner, ConfigClaims& claims) {
  const std::string expected = std::string("a sensor that gives ") +
                               (kind == FrameKind::scan ? "scans: " : "clouds: ") + names_of(config, kind);
  const std::string name = value.text(expected);
  const SensorConfig* sensor = find_source(config, name);
  if (sensor == nullptr) {
    std::vector<std::string_view> known;
    for (const SensorConfig& one : config.sensors) known.push_back(one.name);
    const std::string_view near = nearest_word(name, known);
    value.fail("names " + value.quoted() + ", which is no sensor",
               near.empty() ? expected : std::string(near));
  }
  if (!can_give(*sensor, kind)) value.fail("names " + sensor->name + ", a " + kind_of(*sensor), expected);
  if (sensor->model == nullptr) claims.uses(sensor->name, kind, owner, value);
  return *sensor;
}

void default_ranges(ScanGridSpec& grid, const Sources& sources) {
  double nearest = farthest_m;
  double farthest = 0;
  const ScanGridSpec open;
  for (const SensorConfig* sensor : sources) {
    nearest = std::min(nearest, sensor->model != nullptr ? sensor->model->range_min : open.range_min);
    farthest = std::max(farthest, sensor->model != nullptr ? sensor->model->range_max : open.range_max);
  }
  grid.range_min = nearest;
  grid.range_max = farthest;
}

/// The key that a complaint about the grid is about: the first one it mentions that the user wrote.
const Value& place_of_complaint(const std::string& complaint, const Mapping& yaml) {
  const Value* place = &yaml.self();
  std::size_t earliest = std::string::npos;
  for (const std::string_view key : output_keys) {
    const std::string base(key.substr(0, key.rfind("_deg")));
    const std::size_t mentioned = complaint.find(base);
    if (!yaml.has(key) || mentioned >= earliest) continue;
    earliest = mentioned;
    place = &yaml.where(key);
  }
  return *place;
}

void default_increment(ScanGridSpec& grid) {
  if (grid.beams || grid.angle_increment) return;
  const bool full_turn = std::abs(grid.angle_max - grid.angle_min - 2 * M_PI) < 1e-9;
  if (full_turn)
    grid.beams = default_beams_per_turn;
  else
    grid.angle_increment = 2 * M_PI / static_cast<double>(default_beams_per_turn);
}

void check_grid(const ScanGridSpec& spec, Mapping& yaml, Config& config) {
  std::string complaint;
  const auto grid = make_grid(spec, complaint);
  if (!grid) {
    const Value& place = place_of_complaint(complaint, yaml);
    throw ConfigError(place.place().to_string() + ": " + yaml.self().path() + ": " + complaint);
  }
  if (grid->beams < gmapping_beam_limit) return;
  const Value& place = yaml.where(yaml.has("beams") ? "beams" : "angle_increment");
  warn(config, place.place(),
       yaml.self().path() + " has " + std::to_string(grid->beams) + " beams; gmapping needs fewer than " +
           std::to_string(gmapping_beam_limit) + ": set beams lower where gmapping is to use the scan");
}

void read_grid(Mapping& yaml, ScanGridSpec& grid) {
  if (const auto angle = yaml.angle("angle_min")) grid.angle_min = *angle;
  if (const auto angle = yaml.angle("angle_max")) grid.angle_max = *angle;
  grid.angle_increment = yaml.angle("angle_increment");
  if (const auto beams = yaml.find("beams"))
    grid.beams = static_cast<std::size_t>(beams->integer(2, most_beams));
  if (const auto time = yaml.find("time_increment"))
    grid.time_increment = time->number(0, longest_period_s, "s");
  if (const auto time = yaml.find("scan_time")) grid.scan_time = time->number(0, longest_period_s, "s");
  if (const auto range = yaml.find("range_min")) grid.range_min = range->number(0, farthest_m, "m");
  if (const auto range = yaml.find("range_max")) grid.range_max = range->number(0, farthest_m, "m");
}

void read_heights(Mapping& yaml, OutputScanConfig& output) {
  if (const auto height = yaml.find("min_height"))
    output.min_height = height->number(-farthest_m, farthest_m, "m");
  if (const auto height = yaml.find("max_height"))
    output.max_height = height->number(-farthest_m, farthest_m, "m");
  if (output.min_height && output.max_height && *output.max_height <= *output.min_height)
    yaml.where(yaml.has("max_height") ? "max_height" : "min_height")
        .fail("leaves no height between min_height and max_height", "min_height < max_height");
}

/// The keys that merged and virtual scans share; `output` holds the defaults of the kind.
void read_output(Mapping& yaml, const Sources& sources, bool with_sight, Config& config,
                 OutputScanConfig& output) {
  if (const auto profile = yaml.find("profile")) output.profile = read_profile(*profile, with_sight);
  if (const auto empty = yaml.find("empty")) output.empty = read_empty(*empty);
  if (const auto unobserved = yaml.find("unobserved")) output.unobserved = read_empty(*unobserved);
  read_heights(yaml, output);
  default_ranges(output.grid, sources);
  read_grid(yaml, output.grid);
  default_increment(output.grid);
  check_grid(output.grid, yaml, config);
}

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
  Mapping yaml(entry, with_output_keys({"cloud_topic", "base_frame", "virtual_laser_scan", "poses",
                                        "output_laser_topic"}));
  VirtualScanConfig scan;
  scan.name = name;
  const std::string expected = "a sensor that gives clouds: " + names_of(config, FrameKind::cloud);
  const SensorConfig& source =
      read_source(yaml.require("cloud_topic", expected), FrameKind::cloud, config, entry.path(), claims);
  scan.cloud_topic = source.name;
  const auto base = yaml.find("base_frame");
  scan.base_frame = base ? read_frame(*base) : config.vehicle.base_frame;
  read_frames(yaml, scan);
  read_poses(yaml, entry.path(), claims, scan);
  read_virtual_topics(yaml, entry.path(), config, claims, scan);
  scan.output.min_height = -virtual_half_height_m;
  scan.output.max_height = virtual_half_height_m;
  read_output(yaml, {&source}, false, config, scan.output);
  return scan;
}

}  // namespace

void read_outputs(Mapping& root, Config& config, ConfigClaims& claims) {
  if (const auto section = root.find("merged_scans")) {
    for (const auto& [name, entry] : named_entries(*section)) {
      check_entry_name(name, entry);
      config.merged_scans.push_back(read_merged(name, entry, config, claims));
    }
  }
  if (const auto section = root.find("virtual_scans")) {
    for (const auto& [name, entry] : named_entries(*section)) {
      check_entry_name(name, entry);
      config.virtual_scans.push_back(read_virtual(name, entry, config, claims));
    }
  }
}

}  // namespace lidard
