// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/workers.h"

#include <algorithm>
#include <set>

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

/// True if the worker makes something of frames, or brings clouds to an instant.
bool makes_something(const Config& config, Worker worker) {
  const bool moves_clouds = !config.virtual_scans.empty() || !config.merged_clouds.empty() ||
                            std::any_of(config.sensors.begin(), config.sensors.end(),
                                        [](const SensorConfig& one) { return one.deskew; });
  return (worker == Worker::sensors && !config.merged_scans.empty()) ||
         (worker == config.cloud_worker && moves_clouds);
}

}  // namespace

void assign_workers(Config& config) {
  config.cloud_worker = Worker::clouds;
  std::set<std::uint16_t> ports;
  // A scanner that goes with the clouds brings its ports along.
  for (bool found = true; found;) {
    found = false;
    for (SensorConfig& sensor : config.sensors) {
      const std::vector<Flow> flows = flows_of(sensor);
      const bool shares = std::any_of(flows.begin(), flows.end(), [&](const Flow& flow) {
        return flow.transport == Transport::udp && ports.count(flow.port) > 0;
      });
      if (sensor.worker == Worker::clouds || (!shares && !gives_clouds(sensor, config))) continue;
      sensor.worker = Worker::clouds;
      for (const Flow& flow : flows) {
        if (flow.transport == Transport::udp) ports.insert(flow.port);
      }
      found = true;
    }
  }
}

bool has_clouds(const Config& config) {
  return std::any_of(config.sensors.begin(), config.sensors.end(),
                     [](const SensorConfig& one) { return one.worker == Worker::clouds; });
}

VehicleConfig vehicle_for(const Config& config, Worker worker) {
  VehicleConfig vehicle = config.vehicle;
  const Worker other = worker == Worker::sensors ? Worker::clouds : Worker::sensors;
  const bool follows =
      makes_something(config, worker) || (worker == Worker::sensors && !makes_something(config, other));
  if (!follows) vehicle.odometry_frame = vehicle.odometry_topic = vehicle.imu_topic = "";
  return vehicle;
}

}  // namespace lidard
