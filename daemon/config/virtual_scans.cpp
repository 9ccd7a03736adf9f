// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// `virtual_scans:` of a configuration.
#include <algorithm>
#include <utility>

#include "daemon/config/reading.h"
#include "daemon/config/sections.h"

namespace lidard {
namespace {

using namespace keys;
using Virtual = VirtualScanConfig;

// The first release of ira_laser_tools kept returns within 0.1 m of the plane; later ones 1 cm, then all.
constexpr double virtual_half_height_m = 0.1;

Keys<Virtual> frame_rows() {
  return {special<Virtual>(
              "cloud_topic", "a sensor that gives clouds, or a merged cloud",
              [](const Virtual& scan) { return key_value(scan.cloud_topic); },
              "the source, by name or by the topic that it publishes")
              .needed(),
          frame("base_frame", &Virtual::base_frame, "parent of the poses").by_default("vehicle.base_frame"),
          special<Virtual>(
              "virtual_laser_scan", "names of frames, each the origin of one virtual scan",
              [](const Virtual& scan) { return key_value(scan.virtual_laser_scan); },
              "the frames, each the origin of one scan")
              .needed(),
          special<Virtual>(
              "poses", "{FRAME: {xyz: [x, y, z]}}",
              [](const Virtual& scan) { return KeyMap(scan.poses.begin(), scan.poses.end()); },
              "of the frames in base_frame; a frame without one comes from tf"),
          topic("output_laser_topic", &Virtual::output_laser_topic,
                "the topic of all scans; empty: one topic per frame, named like it")
              .or_empty()};
}

Keys<GroundSettings> ground_rows() {
  using G = GroundSettings;
  const Words<GroundModel> grounds{
      {"none", GroundModel::none}, {"plane", GroundModel::plane}, {"slope", GroundModel::slope}};
  return {word("model", &G::model, grounds, "what the ground is taken for").needed(),
          number("z", &G::z, -farthest_m, farthest_m, "m", "its height in vehicle.base_frame"),
          number("tolerance", &G::tolerance, 0.001, 10, "m", "what lies nearer to it belongs to it")};
}

/// Keys that say how surfaces and free space are found.
Keys<Virtual> evidence_rows() {
  Keys<Virtual> rows{
      word("mode", &Virtual::mode, {{"slice", CutMode::slice}, {"band", CutMode::band}},
           "slice: what crosses the plane; band: all between min_height and max_height"),
      section("ground", within(&Virtual::ground, ground_rows()), "what is no obstacle").in_short(),
      word("echoes", &Virtual::early_returns, {{"last", false}, {"all", true}},
           "which returns count; the surface is made of the last ones"),
      number("no_return_free_range", &Virtual::no_return_free_range, 0, farthest_m, "m",
             "how far a beam without return proves that nothing is there")
          .by_default(
              "of a Velodyne the range of a target of 10 % remission where it is known, else range_max; of "
              "others 0; the least of a merged cloud's lidars")};
  for (auto& row : rows) row.shown = [](const Virtual& scan) { return scan.has_visibility(); };
  return rows;
}

void read_frames(Mapping& yaml, Virtual& scan) {
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

void read_poses(Mapping& yaml, Virtual& scan, Reading& reading) {
  const std::vector<std::string_view> frames(scan.virtual_laser_scan.begin(), scan.virtual_laser_scan.end());
  if (std::find(frames.begin(), frames.end(), scan.base_frame) != frames.end())
    scan.poses[scan.base_frame] = Pose::Identity();
  const auto section = yaml.find("poses");
  if (!section) return;
  Mistakes mistakes;
  const Mapping poses(*section, frames, &mistakes);
  for (const auto& [frame, value] : poses.entries()) {
    mistakes.attempt([&, &frame = frame, &value = value] {
      const Pose pose = read_pose(value);
      reading.claims.holds_frame(frame, scan.base_frame, pose, yaml.self().path(), value);
      scan.poses[frame] = pose;
    });
  }
  mistakes.throw_if_any();
}

void claim_topics(Mapping& yaml, const Virtual& scan, Reading& reading) {
  const std::string& owner = yaml.self().path();
  if (scan.output_laser_topic.empty()) {
    for (const Value& frame : yaml.where("virtual_laser_scan").names("names of frames"))
      reading.claims.publishes(read_topic(frame), owner, frame);
  } else {
    const Value& topic = yaml.where("output_laser_topic");
    reading.claims.publishes(scan.output_laser_topic, owner, topic);
    if (scan.virtual_laser_scan.size() > 1)
      reading.warn(topic.place(), topic.path() + " carries scans of " +
                                      std::to_string(scan.virtual_laser_scan.size()) +
                                      " frames; leave it empty for one topic per frame");
  }
  for (const AlsoScanConfig& also : scan.also) {
    const Mapping section = yaml.inside("also");
    for (const std::string& frame : scan.virtual_laser_scan) {
      reading.claims.publishes(scan.topic(frame, &also), owner, section.where(also.topic));
      if (!scan.output_laser_topic.empty()) break;
    }
  }
}

/// What proves nothing needs no key that says how.
void refuse_without_visibility(const Mapping& yaml) {
  for (const Key& key : evidence_rows()) {
    if (yaml.has(key.name))
      yaml.where(key.name).fail("is of no use for a scan of profile flatten, which is points alone",
                                "profile: strict or safety (or such a scan under also), or no such key");
  }
}

/// What follows for the sources of a scan that knows free space.
void prepare_sources(const std::vector<std::string>& sources, Reading& reading) {
  // A beam that met something too near to measure is not free.
  for (SensorConfig& sensor : reading.config.sensors) {
    if (std::find(sources.begin(), sources.end(), sensor.name) != sources.end())
      sensor.driver.keep_too_near = true;
  }
}

/// A beam without return of these proves that nothing is there. Of other drivers' clouds nobody knows whether
/// a beam was fired.
double default_free_range(const SensorConfig& sensor) {
  return sensor.model != nullptr && sensor.model->has(Trait::silent_beams_are_free)
             ? sensor.model->free_range()
             : 0;
}

/// The sensors behind cloud_topic.
std::vector<std::string> read_cloud_source(Mapping& yaml, Virtual& scan, Reading& reading) {
  std::string expected = "a sensor that gives clouds: " + names_of(reading.config, FrameKind::cloud);
  const char* separator = "; or a merged cloud: ";
  for (const MergedCloudConfig& merged : reading.config.merged_clouds)
    expected += std::exchange(separator, ", ") + merged.name;
  const Value named = yaml.require("cloud_topic", expected);
  const NamedSource source = read_source(named, FrameKind::cloud, reading, expected);
  if (source.sensor != nullptr)
    reading.claims.uses(*source.sensor, FrameKind::cloud, yaml.self().path(), named);
  scan.cloud_topic = source.name;
  return reading.config.lidars_of(scan);
}

/// What holds for a scan of these sensors unless the file says otherwise.
void set_defaults(const std::vector<std::string>& sources, const Config& config, Virtual& scan) {
  std::vector<SourceLimits> limits;
  std::optional<double> free_range;
  for (const std::string& name : sources) {
    const SensorConfig& sensor = *config.find_sensor(name);
    limits.emplace_back(sensor);
    if (sensor.model != nullptr && sensor.model->kind == FrameKind::scan) continue;
    const double own = default_free_range(sensor);
    free_range = std::min(own, free_range.value_or(own));
  }
  default_ranges(limits, scan.output.grid);
  scan.no_return_free_range = free_range.value_or(0);
}

Virtual read_virtual(const std::string& name, const Value& entry, Reading& reading) {
  Mistakes mistakes;
  Mapping yaml = mapping_of(entry, virtual_keys(), mistakes);
  Virtual scan = default_virtual_scan();
  scan.name = name;
  scan.base_frame = reading.config.vehicle.base_frame;
  std::vector<std::string> sources;
  mistakes.attempt([&] { sources = read_cloud_source(yaml, scan, reading); });
  set_defaults(sources, reading.config, scan);
  const bool has_frames = mistakes.attempt([&] { read_frames(yaml, scan); });
  read_keys(yaml, virtual_keys(), scan, mistakes);
  mistakes.attempt([&] { read_also(yaml, scan.also); });
  if (has_frames) mistakes.attempt([&] { read_poses(yaml, scan, reading); });
  // The rules between keys need all of them.
  mistakes.throw_if_any();
  mistakes.attempt([&] { claim_topics(yaml, scan, reading); });
  mistakes.attempt([&] { check_output(yaml, scan.output, reading); });
  if (!scan.has_visibility()) mistakes.attempt([&] { refuse_without_visibility(yaml); });
  mistakes.throw_if_any();
  if (scan.has_visibility()) prepare_sources(sources, reading);
  return scan;
}

}  // namespace

Virtual default_virtual_scan() {
  Virtual scan;
  scan.output.min_height = -virtual_half_height_m;
  scan.output.max_height = virtual_half_height_m;
  // Without a ground an obstacle is met only between two rings that both see it.
  scan.ground.model = GroundModel::slope;
  return scan;
}

bool VirtualScanConfig::has_visibility() const { return knows_free_space(output, also); }

std::string VirtualScanConfig::topic(const std::string& frame, const AlsoScanConfig* further) const {
  const std::string own = output_laser_topic.empty() ? frame : output_laser_topic;
  return further == nullptr ? own : own + "/" + further->topic;
}

const Keys<Virtual>& virtual_keys() {
  static const Keys<Virtual> rows = [] {
    Keys<Virtual> all = joined<Virtual>(
        {frame_rows(), within(&Virtual::output, output_keys()), {also_row<Virtual>()}, evidence_rows()});
    // Requests at run time may change the profile of merged scans alone.
    for (Key& key : all) key.live = key.live && key.name != "profile";
    return all;
  }();
  return rows;
}

void read_virtual_scans(Mapping& root, Reading& reading) {
  read_entries(root.find("virtual_scans"), reading.config.virtual_scans, reading, read_virtual);
}

}  // namespace lidard
