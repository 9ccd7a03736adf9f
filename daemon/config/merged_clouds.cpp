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

MergedCloudConfig read_merged_cloud(const std::string& name, const Value& entry, Reading& reading) {
  if (reading.config.find_sensor(name) != nullptr)
    entry.fail_at_key("is the name of a sensor too", "a name of its own");
  Mistakes mistakes;
  Mapping yaml = mapping_of(entry, merged_cloud_keys(), mistakes);
  MergedCloudConfig merged;
  merged.name = name;
  merged.destination_frame = reading.config.vehicle.base_frame;
  merged.destination_topic = name;
  std::string expected = "names of sensors:";
  for (const SensorConfig& sensor : reading.config.sensors) expected += " " + sensor.name;
  SourceList list;
  mistakes.attempt([&] { list = read_sources(yaml, "sources", expected, kind_called, reading); });
  merged.sources = list.names;
  read_keys(yaml, merged_cloud_keys(), merged, mistakes);
  mistakes.throw_if_any();
  check_destination(yaml, merged.destination_frame, merged.destination_pose, reading);
  const Value& place = yaml.where("destination_topic");
  if (reading.config.find_sensor(merged.destination_topic) != nullptr)
    place.fail("is the name of a sensor too", "a topic of its own");
  reading.claims.publishes(merged.destination_topic, yaml.self().path(), place);
  check_policy(yaml, list, merged.schedule);
  return merged;
}

}  // namespace

const Keys<MergedCloudConfig>& merged_cloud_keys() {
  static const Keys<MergedCloudConfig> all =
      joined<MergedCloudConfig>({source_and_order_rows(), schedule_rows(&MergedCloudConfig::sources)});
  return all;
}

void read_merged_clouds(Mapping& root, Reading& reading) {
  read_entries(root.find("merged_clouds"), reading.config.merged_clouds, reading, read_merged_cloud);
}

}  // namespace lidard
