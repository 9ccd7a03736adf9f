// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config/config.h"

#include <set>
#include <utility>

#include "daemon/config/rows.h"

namespace lidard {
namespace {

/// True if `a` and `b` show the same values of all keys.
template <class Section>
bool same_values(Keys (*keys)(Section&), Section a, Section b) {
  return KeyValue(shown_values(keys(a))) == KeyValue(shown_values(keys(b)));
}

}  // namespace

const SensorConfig* Config::find_sensor(const std::string& name) const {
  return lidard::find_sensor(sensors, name);
}

std::vector<std::string> Config::lidars_of(const VirtualScanConfig& group) const {
  for (const MergedCloudConfig& merged : merged_clouds) {
    if (merged.destination_topic == group.cloud_topic) return merged.sources;
  }
  return {group.cloud_topic};
}

bool operator==(const VehicleConfig& a, const VehicleConfig& b) { return same_values(vehicle_keys, a, b); }
bool operator==(const SensorConfig& a, const SensorConfig& b) {
  // What another entry's profile asks of the driver counts too.
  return a.name == b.name && a.model == b.model && a.calibration_digest == b.calibration_digest &&
         a.driver.keep_too_near == b.driver.keep_too_near && same_values(sensor_keys, a, b);
}
bool operator==(const MergedScanConfig& a, const MergedScanConfig& b) {
  return a.name == b.name && same_values(merged_keys, a, b);
}
bool operator==(const MergedCloudConfig& a, const MergedCloudConfig& b) {
  return a.name == b.name && same_values(merged_cloud_keys, a, b);
}
bool operator==(const VirtualScanConfig& a, const VirtualScanConfig& b) {
  return a.name == b.name && same_values(virtual_keys, a, b);
}

std::vector<StaticTransform> fixed_poses(const Config& config) {
  std::vector<StaticTransform> poses;
  std::set<std::string> known;
  const auto add = [&](const std::string& parent, const std::string& child, const Pose& pose) {
    // A frame has one parent (REP 105); the first entry that names it counts.
    if (child != parent && known.insert(child).second) poses.push_back({parent, child, pose});
  };
  for (const StaticTransform& one : config.elsewhere.poses) add(one.parent, one.child, one.pose);
  const std::string& base = config.vehicle.base_frame;
  for (const SensorConfig& sensor : config.sensors) {
    if (sensor.pose) add(base, sensor.frame_id, *sensor.pose);
  }
  for (const MergedScanConfig& merged : config.merged_scans) {
    if (merged.destination_pose) add(base, merged.destination_frame, *merged.destination_pose);
  }
  for (const MergedCloudConfig& merged : config.merged_clouds) {
    if (merged.destination_pose) add(base, merged.destination_frame, *merged.destination_pose);
  }
  for (const VirtualScanConfig& group : config.virtual_scans) {
    for (const auto& [frame, pose] : group.poses) add(group.base_frame, frame, pose);
  }
  return poses;
}

std::vector<OutputTopic> output_topics(const Config& config) {
  std::vector<OutputTopic> topics;
  const auto add = [&](const std::vector<OutputTopic>& of_entry) {
    for (const OutputTopic& topic : of_entry) {
      topics.push_back(topic);
      topics.back().id = topics.size() - 1;
    }
  };
  for (const SensorConfig& sensor : config.sensors) add(sensor_topics(sensor));
  for (const MergedScanConfig& merged : config.merged_scans) add(merged.topics());
  for (const MergedCloudConfig& merged : config.merged_clouds) add(merged.topics());
  for (const VirtualScanConfig& group : config.virtual_scans) add(group.topics());
  return topics;
}

}  // namespace lidard
