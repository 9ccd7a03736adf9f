// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/division.h"

#include <algorithm>
#include <set>
#include <utility>

namespace lidard {
namespace {

bool gives_clouds(const SensorConfig& sensor, const Config& config) {
  const auto is_merged = [&](const MergedCloudConfig& merged) {
    return std::find(merged.sources.begin(), merged.sources.end(), sensor.name) != merged.sources.end();
  };
  const auto is_cut = [&](const VirtualScanConfig& group) { return group.cloud_topic == sensor.name; };
  return (sensor.model != nullptr && sensor.model->kind == FrameKind::cloud) ||
         std::any_of(config.merged_clouds.begin(), config.merged_clouds.end(), is_merged) ||
         std::any_of(config.virtual_scans.begin(), config.virtual_scans.end(), is_cut);
}

/// The names of the sensors that go with the clouds.
std::set<std::string> with_clouds(const Config& config) {
  std::set<std::string> names;
  std::set<std::uint16_t> ports;
  // A scanner that goes with the clouds brings its ports along.
  for (bool found = true; found;) {
    found = false;
    for (const SensorConfig& sensor : config.sensors) {
      const std::vector<Flow> flows = flows_of(sensor);
      const bool shares = std::any_of(flows.begin(), flows.end(), [&](const Flow& flow) {
        return flow.transport == Transport::udp && ports.count(flow.port) > 0;
      });
      if (names.count(sensor.name) > 0 || (!shares && !gives_clouds(sensor, config))) continue;
      names.insert(sensor.name);
      for (const Flow& flow : flows) {
        if (flow.transport == Transport::udp) ports.insert(flow.port);
      }
      found = true;
    }
  }
  return names;
}

/// True if something is made of frames, or clouds are brought to an instant.
bool uses_motion(const Config& part) {
  return !part.merged_scans.empty() || !part.virtual_scans.empty() || !part.merged_clouds.empty() ||
         std::any_of(part.sensors.begin(), part.sensors.end(),
                     [](const SensorConfig& one) { return one.deskew; });
}

void drop_motion(VehicleConfig& vehicle) {
  vehicle.odometry_frame = vehicle.odometry_topic = vehicle.imu_topic = "";
}

}  // namespace

Division::Division(Config config) : whole(std::move(config)), planes(whole), clouds(whole) {
  const std::set<std::string> names = with_clouds(whole);
  planes.elsewhere.poses = clouds.elsewhere.poses = fixed_poses(whole);
  const auto remove = [&](Config& part, bool with) {
    auto& all = part.sensors;
    all.erase(std::remove_if(all.begin(), all.end(),
                             [&](const SensorConfig& one) { return (names.count(one.name) > 0) == with; }),
              all.end());
    part.elsewhere.has_sensors = all.size() < whole.sensors.size();
  };
  remove(planes, true);
  remove(clouds, false);
  planes.merged_clouds.clear();
  planes.virtual_scans.clear();
  clouds.merged_scans.clear();
  for (const MergedScanConfig& merged : whole.merged_scans) {
    for (const std::string& source : merged.laserscan_topics)
      if (planes.find_sensor(source) == nullptr) clouds.elsewhere.merged.insert(source);
  }
  // One thread at least reports the state of the motion.
  const bool clouds_follow = uses_motion(clouds);
  if (!uses_motion(planes) && clouds_follow) drop_motion(planes.vehicle);
  if (!clouds_follow) drop_motion(clouds.vehicle);
}

}  // namespace lidard
