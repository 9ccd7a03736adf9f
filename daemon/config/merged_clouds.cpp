// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config/merged_clouds.h"

#include <algorithm>

#include "daemon/config/reading.h"
#include "daemon/config/rows.h"
#include "daemon/config/sensors.h"
#include "daemon/config/vehicle.h"

namespace lidard {
namespace {

/// The kind of frames that the source of that name gives.
FrameKind kind_called(const Value& value, const Reading& reading) {
  const std::string name = without_slash(value.text());
  const auto& sensors = reading.sensors;
  const bool scans = std::any_of(sensors.begin(), sensors.end(), [&](const SensorConfig& sensor) {
    return sensor.model != nullptr && sensor.model->kind == FrameKind::scan &&
           (sensor.name == name || without_slash(frame_topic(sensor).name) == name);
  });
  return scans ? FrameKind::scan : FrameKind::cloud;
}

void check_merged_cloud(const Mapping& yaml, const SourceList& list, MergedCloudConfig& merged,
                        Reading& reading) {
  check_destination(yaml, merged.destination_frame, merged.destination_pose, reading);
  const Value& topic = yaml.where("destination_topic");
  if (find_sensor(reading.sensors, merged.destination_topic) != nullptr)
    topic.fail("is the name of a sensor too", "a topic of its own");
  reading.claims.publishes(merged.destination_topic, yaml.self().path(), topic);
  check_schedule(yaml, list, merged.schedule);
}

MergedCloudConfig read_merged_cloud(const std::string& name, const Value& entry, Reading& reading) {
  if (find_sensor(reading.sensors, name) != nullptr)
    entry.fail_at_key("is the name of a sensor too", "a name of its own");
  Mistakes mistakes;
  MergedCloudConfig merged;
  const Keys keys = merged_cloud_keys(merged);
  const Mapping yaml = mapping_of(entry, keys, mistakes);
  merged.name = name;
  merged.destination_frame = reading.vehicle.base_frame;
  merged.destination_topic = name;
  std::string expected = "names of sensors:";
  for (const SensorConfig& sensor : reading.sensors) expected += " " + sensor.name;
  SourceList list;
  mistakes.attempt([&] { list = read_sources(yaml, "sources", expected, kind_called, reading); });
  merged.sources = list.names;
  read_keys(yaml, keys, mistakes);
  mistakes.throw_if_any();
  check_merged_cloud(yaml, list, merged, reading);
  const Source source{Source::Kind::merged_cloud, merged.destination_topic, 0, 0, 0, false, merged.sources};
  for (const std::string& called : {merged.name, merged.destination_topic})
    reading.candidates.push_back({called, FrameKind::cloud, source, "merged_clouds." + merged.name,
                                  "a merged cloud, which gives no scans"});
  return merged;
}

}  // namespace

Keys merged_cloud_keys(MergedCloudConfig& merged) {
  using namespace keys;
  return join(
      {{{"sources", merged.sources, special("names of sensors"),
         "the lidars and planar scanners, by name or by the topic that they publish; `topic:` is taken for a "
         "cloud",
         needed},
        {"destination_frame", merged.destination_frame, frame, "the frame of the returns",
         preset("vehicle.base_frame")},
        {"destination_pose", merged.destination_pose, pose, "of destination_frame in vehicle.base_frame",
         remark("from tf")},
        {"destination_topic", merged.destination_topic, topic, "the cloud", preset("the entry's name")},
        {"organize_cloud", merged.organized, flag,
         "with a row per ring, source by source, in place of a list of returns"}},
       schedule_keys(merged.schedule, merged.on_missing_motion, merged.sources)});
}

void read_merged_clouds(const Mapping& root, Reading& reading) {
  read_entries(root.find("merged_clouds"), reading.merged_clouds, reading, read_merged_cloud);
}

}  // namespace lidard
