// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// `merged_clouds:` of a configuration.
#include <algorithm>

#include "daemon/config/reading.h"
#include "daemon/config/sections.h"

namespace lidard {
namespace {

using namespace keys;

Keys<MergedCloudConfig> source_and_order_rows() {
  return {special<MergedCloudConfig>(
              "sources", "names of sensors",
              [](const MergedCloudConfig& merged) { return key_value(merged.sources); },
              "the lidars and planar scanners, by name or by the topic that they publish; `topic:` is taken "
              "for a cloud")
              .needed(),
          frame("destination_frame", &MergedCloudConfig::destination_frame, "the frame of the returns")
              .by_default("vehicle.base_frame"),
          of_kind(KeyKind::pose, "destination_pose", &MergedCloudConfig::destination_pose,
                  "of destination_frame in vehicle.base_frame")
              .unless_set("from tf"),
          topic("destination_topic", &MergedCloudConfig::destination_topic, "the cloud")
              .by_default("the entry's name"),
          flag("organize_cloud", &MergedCloudConfig::organized,
               "with a row per ring, source by source, in place of a list of returns")};
}

/// The kind of frames that the source of that name gives.
FrameKind kind_called(const Value& value, const Config& config) {
  const std::string name = without_slash(value.text());
  const bool scans =
      std::any_of(config.sensors.begin(), config.sensors.end(), [&](const SensorConfig& sensor) {
        return sensor.model != nullptr && sensor.model->kind == FrameKind::scan &&
               (sensor.name == name || without_slash(frame_topic(sensor).name) == name);
      });
  return scans ? FrameKind::scan : FrameKind::cloud;
}

void add_source(const Value& value, const std::string& expected, const std::string& owner, Reading& reading,
                SourceList& list) {
  const FrameKind kind = kind_called(value, reading.config);
  const NamedSource source = read_source(value, kind, reading, expected);
  if (source.sensor == nullptr) value.fail("names " + value.quoted() + ", a merged cloud", expected);
  if (std::find(list.names.begin(), list.names.end(), source.name) != list.names.end())
    value.fail("names " + source.name + " again", "every sensor once");
  reading.claims.uses(*source.sensor, kind, owner, value);
  list.names.push_back(source.name);
  list.written.push_back(value.text());
}

/// Mistakes with the sources leave the whole entry uncertain.
SourceList read_sources(Mapping& yaml, Reading& reading) {
  SourceList list{"sources", {}, {}};
  bool complete = true;
  complete &= reading.mistakes.attempt(yaml.self().place(), [&] {
    std::string expected = "names of sensors:";
    for (const SensorConfig& sensor : reading.config.sensors) expected += " " + sensor.name;
    const Value value = yaml.require("sources", expected);
    const std::vector<Value> values = value.names(expected);
    if (values.empty()) value.fail("names nothing", expected);
    for (const Value& one : values)
      complete &= reading.mistakes.attempt(
          one.place(), [&] { add_source(one, expected, yaml.self().path(), reading, list); });
  });
  if (!complete) reading.mistakes.mark_invalid(yaml.self().path());
  return list;
}

MergedCloudConfig read_merged_cloud(const std::string& name, const Value& entry, Reading& reading) {
  if (reading.config.find_sensor(name) != nullptr)
    entry.fail_at_key("is the name of a sensor too", "a name of its own");
  Mapping yaml = mapping_of(entry, merged_cloud_keys(), reading.mistakes);
  MergedCloudConfig merged;
  merged.name = name;
  merged.destination_frame = reading.config.vehicle.base_frame;
  merged.destination_topic = name;
  const SourceList list = read_sources(yaml, reading);
  merged.sources = list.names;
  read_keys(yaml, merged_cloud_keys(), merged);
  yaml.attempt_rule(
      [&] { check_destination(yaml, merged.destination_frame, merged.destination_pose, reading); });
  yaml.attempt_rule([&] {
    const Value& place = yaml.where("destination_topic");
    if (reading.config.find_sensor(merged.destination_topic) != nullptr)
      place.fail("is the name of a sensor too", "a topic of its own");
    reading.claims.publishes(merged.destination_topic, yaml.self().path(), place);
  });
  yaml.attempt_rule([&] { check_policy(yaml, list, merged.schedule); });
  return merged;
}

}  // namespace

const Keys<MergedCloudConfig>& merged_cloud_keys() {
  static const Keys<MergedCloudConfig> all =
      joined<MergedCloudConfig>({source_and_order_rows(), schedule_rows(&MergedCloudConfig::sources)});
  return all;
}

void read_merged_clouds(Mapping& root, Reading& reading) {
  root.attempt("merged_clouds", [&] {
    if (const auto section = root.find("merged_clouds"))
      read_entries(*section, reading.config.merged_clouds, reading, read_merged_cloud);
  });
}

}  // namespace lidard
