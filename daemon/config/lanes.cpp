// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config/lanes.h"

#include <algorithm>
#include <set>

namespace lidard {
namespace {

using Names = std::set<std::string>;

/// A planar scanner that is a source of a merged cloud goes with it.
bool is_merged(const SensorConfig& sensor, const MergedCloudConfig& merged) {
  return std::find(merged.sources.begin(), merged.sources.end(), sensor.name) != merged.sources.end();
}

bool gives_clouds(const SensorConfig& sensor, const Config& config) {
  if (std::any_of(config.merged_clouds.begin(), config.merged_clouds.end(),
                  [&](const MergedCloudConfig& merged) { return is_merged(sensor, merged); }))
    return true;
  if (sensor.model != nullptr) return sensor.model->kind == FrameKind::cloud;
  return std::any_of(config.virtual_scans.begin(), config.virtual_scans.end(),
                     [&](const VirtualScanConfig& group) { return group.cloud_topic == sensor.name; });
}

std::set<std::uint16_t> udp_ports_of(const SensorConfig& sensor) {
  std::set<std::uint16_t> ports;
  for (const Flow& flow : flows_of(sensor)) {
    if (flow.transport == Transport::udp) ports.insert(flow.port);
  }
  return ports;
}

/// True if clouds of the configuration are brought to an instant, or become scans that are.
bool moves_clouds(const Config& config) {
  return !config.virtual_scans.empty() || !config.merged_clouds.empty() ||
         std::any_of(config.sensors.begin(), config.sensors.end(),
                     [](const SensorConfig& one) { return one.deskew; });
}

/// The sensors of the lane of clouds.
Names sensors_with_clouds(const Config& config) {
  Names names;
  std::set<std::uint16_t> ports;
  // Each round but the last one finds a sensor.
  for (std::size_t known = 0, round = 0; round == 0 || names.size() > known; ++round) {
    known = names.size();
    for (const SensorConfig& sensor : config.sensors) {
      const std::set<std::uint16_t> own = udp_ports_of(sensor);
      const bool shares =
          std::any_of(own.begin(), own.end(), [&](auto port) { return ports.count(port) > 0; });
      if (!shares && !gives_clouds(sensor, config)) continue;
      names.insert(sensor.name);
      ports.insert(own.begin(), own.end());
    }
  }
  return names;
}

/// What merged scans take that does not come from a sensor of the lane of planes.
Names handed_over(const Config& config, const Names& with_clouds) {
  Names names;
  for (const MergedScanConfig& merged : config.merged_scans) {
    for (const std::string& source : merged.laserscan_topics) {
      if (config.find_sensor(source) == nullptr || with_clouds.count(source) > 0) names.insert(source);
    }
  }
  return names;
}

}  // namespace

Config part_of(const Config& config, Lane lane) {
  const Names with_clouds = sensors_with_clouds(config);
  const Names over = handed_over(config, with_clouds);
  Config part = config;
  part.poses = fixed_poses(config);
  part.warnings.clear();
  const auto is_foreign = [&](const SensorConfig& sensor) {
    return (with_clouds.count(sensor.name) > 0) != (lane == Lane::clouds);
  };
  // Only what is made of frames needs to know how the vehicle moves.
  const bool makes_nothing = lane == Lane::clouds ? !moves_clouds(config) && !config.merged_scans.empty()
                                                  : config.merged_scans.empty() && moves_clouds(config);
  if (makes_nothing) part.vehicle.odometry_frame = part.vehicle.odometry_topic = part.vehicle.imu_topic = "";
  part.is_not_alone = std::any_of(part.sensors.begin(), part.sensors.end(), is_foreign);
  part.sensors.erase(std::remove_if(part.sensors.begin(), part.sensors.end(), is_foreign),
                     part.sensors.end());
  if (lane == Lane::clouds) {
    part.merged_scans.clear();
    part.hand_over.assign(over.begin(), over.end());
    return part;
  }
  part.merged_clouds.clear();
  part.virtual_scans.clear();
  part.handed_over.assign(over.begin(), over.end());
  return part;
}

}  // namespace lidard
