// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config/virtual_scans.h"

#include <algorithm>
#include <utility>

#include "daemon/config/merged_clouds.h"
#include "daemon/config/reading.h"
#include "daemon/config/rows.h"
#include "daemon/config/sensors.h"
#include "daemon/config/vehicle.h"

namespace lidard {
namespace {

using Virtual = VirtualScanConfig;

// The first release of ira_laser_tools kept returns within 0.1 m of the plane; later ones 1 cm, then all.
constexpr double virtual_half_height_m = 0.1;

Keys ground_keys(GroundSettings& ground) {
  using namespace keys;
  return {{"model", ground.model,
           word({{"none", GroundModel::none}, {"plane", GroundModel::plane}, {"slope", GroundModel::slope}}),
           "what the ground is taken for", needed},
          {"z", ground.z, number(-farthest_m, farthest_m, "m"), "its height in vehicle.base_frame"},
          {"tolerance", ground.tolerance, number(0.001, 10, "m"), "what lies nearer to it belongs to it"}};
}

constexpr const char* frames_form = "names of frames, each the origin of one virtual scan";

std::vector<std::string> read_frames(const Value& list) {
  std::vector<std::string> frames;
  for (const Value& value : list.names(frames_form)) {
    const std::string frame = read_frame(value);
    if (std::find(frames.begin(), frames.end(), frame) != frames.end())
      value.fail("names " + frame + " again", "every frame once");
    frames.push_back(frame);
  }
  if (frames.empty()) list.fail("names nothing", frames_form);
  return frames;
}

void read_poses(const Mapping& yaml, Virtual& scan, Reading& reading) {
  const std::vector<std::string_view> frames(scan.virtual_laser_scan.begin(), scan.virtual_laser_scan.end());
  if (std::find(frames.begin(), frames.end(), scan.base_frame) != frames.end())
    scan.poses[scan.base_frame] = Pose::Identity();
  const auto section = yaml.find("poses");
  if (!section) return;
  read_each(*section, frames, [&](const std::string& frame, const Value& value) {
    const Pose pose = read_pose(value);
    reading.claims.holds_frame(frame, scan.base_frame, pose, yaml.self().path(), value);
    scan.poses[frame] = pose;
  });
}

void claim_topics(const Mapping& yaml, const Virtual& scan, Reading& reading) {
  const std::string& owner = yaml.self().path();
  if (scan.output_laser_topic.empty()) {
    for (const Value& frame : yaml.where("virtual_laser_scan").names("names of frames"))
      reading.claims.publishes(read_topic(frame), owner, frame);
  } else {
    const Value& topic = yaml.where("output_laser_topic");
    reading.claims.publishes(scan.output_laser_topic, owner, topic);
    if (scan.virtual_laser_scan.size() > 1)
      reading.warn(topic.location(), topic.path() + " carries scans of " +
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

/// Rejects keys that say how what is proven is found, where nothing is.
void refuse_without_visibility(const Mapping& yaml, Virtual& scan) {
  for (const Key& key : virtual_keys(scan)) {
    if (yaml.has(key.name) && !key.applies)
      yaml.where(key.name).fail("is of no use for a scan of profile flatten, which is points alone",
                                "profile: strict or safety (or such a scan under also), or no such key");
  }
}

/// What follows for the sources of a scan that knows free space.
void prepare_sources(const std::vector<std::string>& sources, Reading& reading) {
  // A beam that met something too near to measure is not free.
  for (SensorConfig& sensor : reading.sensors) {
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
std::vector<std::string> read_cloud_source(const Mapping& yaml, Virtual& scan, Reading& reading) {
  std::string expected = "a sensor that gives clouds: " + names_of(reading.sensors, FrameKind::cloud);
  const char* separator = "; or a merged cloud: ";
  for (const MergedCloudConfig& merged : reading.merged_clouds)
    expected += std::exchange(separator, ", ") + merged.name;
  const Value named = yaml.require("cloud_topic", expected);
  const Source source = read_source(named, FrameKind::cloud, reading, expected);
  if (source.kind == Source::Kind::topic)
    reading.claims.uses(source.name, FrameKind::cloud, yaml.self().path(), named);
  scan.cloud_topic = source.name;
  return source.kind == Source::Kind::merged_cloud ? source.merged : std::vector<std::string>{source.name};
}

/// What holds for a scan of these sensors unless the file says otherwise.
void set_defaults(const std::vector<std::string>& sources, const std::vector<SensorConfig>& sensors,
                  Virtual& scan) {
  std::vector<Source> limits;
  std::optional<double> free_range;
  for (const std::string& name : sources) {
    const SensorConfig& sensor = *find_sensor(sensors, name);
    limits.push_back(source_of(sensor));
    if (sensor.model != nullptr && sensor.model->kind == FrameKind::scan) continue;
    const double own = default_free_range(sensor);
    free_range = std::min(own, free_range.value_or(own));
  }
  default_ranges(limits, scan.output.grid);
  scan.no_return_free_range = free_range.value_or(0);
}

void check_virtual_scan(const Mapping& yaml, const std::vector<std::string>& sources, Virtual& scan,
                        Reading& reading) {
  Mistakes mistakes;
  mistakes.attempt([&] { claim_topics(yaml, scan, reading); });
  mistakes.attempt([&] { check_output(yaml, scan.output, reading); });
  mistakes.attempt([&] { refuse_without_visibility(yaml, scan); });
  mistakes.throw_if_any();
  if (scan.has_visibility()) prepare_sources(sources, reading);
}

/// Adds the topics that carry the scans of one frame each.
void add_candidates(const Virtual& group, std::vector<Candidate>& candidates) {
  if (!group.output_laser_topic.empty() && group.virtual_laser_scan.size() > 1) return;
  const ScanGridSpec& grid = group.output.grid;
  for (const std::string& frame : group.virtual_laser_scan) {
    const Source source{Source::Kind::virtual_scan,
                        group.topic(frame),
                        grid.range_min,
                        grid.range_max,
                        0,
                        group.output.profile == Profile::flatten};
    candidates.push_back({source.name, FrameKind::scan, source, "the topic of virtual_scans." + group.name,
                          "a virtual scan, which gives no clouds"});
  }
}

Virtual read_virtual(const std::string& name, const Value& entry, Reading& reading) {
  Mistakes mistakes;
  Virtual scan = default_virtual_scan();
  const Keys keys = virtual_keys(scan);
  const Mapping yaml = mapping_of(entry, keys, mistakes);
  scan.name = name;
  scan.base_frame = reading.vehicle.base_frame;
  std::vector<std::string> sources;
  mistakes.attempt([&] { sources = read_cloud_source(yaml, scan, reading); });
  set_defaults(sources, reading.sensors, scan);
  read_keys(yaml, keys, mistakes);
  if (!scan.virtual_laser_scan.empty()) mistakes.attempt([&] { read_poses(yaml, scan, reading); });
  // The rules between keys need all of them.
  mistakes.throw_if_any();
  check_virtual_scan(yaml, sources, scan, reading);
  add_candidates(scan, reading.candidates);
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

std::vector<OutputTopic> VirtualScanConfig::topics() const {
  std::vector<OutputTopic> topics;
  for (const std::string& frame : virtual_laser_scan) {
    topics.push_back({topic(frame), TopicKind::scan});
    for (const AlsoScanConfig& one : also) topics.push_back({topic(frame, &one), TopicKind::scan});
    if (!output_laser_topic.empty()) break;
  }
  return topics;
}

std::string VirtualScanConfig::topic(const std::string& frame, const AlsoScanConfig* further) const {
  const std::string own = output_laser_topic.empty() ? frame : output_laser_topic;
  return further == nullptr ? own : own + "/" + further->topic;
}

Keys virtual_keys(Virtual& scan) {
  using namespace keys;
  Keys all = join(
      {{{"cloud_topic", scan.cloud_topic, special("a sensor that gives clouds, or a merged cloud"),
         "the source, by name or by the topic that it publishes", needed},
        {"base_frame", scan.base_frame, frame, "parent of the poses", preset("vehicle.base_frame")},
        {"virtual_laser_scan", KeyList(scan.virtual_laser_scan.begin(), scan.virtual_laser_scan.end()),
         [&](const Value& value) { scan.virtual_laser_scan = read_frames(value); }, special(frames_form),
         "the frames, each the origin of one scan", needed},
        {"poses", KeyMap(scan.poses.begin(), scan.poses.end()), special("{FRAME: {xyz: [x, y, z]}}"),
         "of the frames in base_frame; a frame without one comes from tf"},
        {"output_laser_topic", scan.output_laser_topic, topic,
         "the topic of all scans; empty: one topic per frame, named like it", or_none}},
       output_keys(scan.output),
       {also_key(scan.also)},
       only_if(
           scan.has_visibility(),
           {{"mode", scan.mode, word({{"slice", CutMode::slice}, {"band", CutMode::band}}),
             "slice: what crosses the plane; band: all between min_height and max_height"},
            {"ground", ground_keys(scan.ground), "what is no obstacle", SectionStyle::brief},
            {"echoes", scan.early_returns, word({{"last", false}, {"all", true}}),
             "which returns count; the surface is made of the last ones"},
            {"no_return_free_range", scan.no_return_free_range, number(0, farthest_m, "m"),
             "how far a beam without return proves that nothing is there",
             preset(
                 "of a Velodyne the range of a target of 10 % remission where it is known, else range_max; "
                 "of others 0; the least of a merged cloud's lidars")}})});
  // Requests at run time may change the profile of merged scans alone.
  for (Key& key : all) key.live = key.live && key.name != "profile";
  return all;
}

void read_virtual_scans(const Mapping& root, Reading& reading) {
  read_entries(root.find("virtual_scans"), reading.virtual_scans, reading, read_virtual);
}

}  // namespace lidard
