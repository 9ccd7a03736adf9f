// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "daemon/config/config.h"
#include "drivers/key.h"

namespace lidard {

/// The keys of each section, in the order in which they are read and written.
const Keys<VehicleConfig>& vehicle_keys();
const Keys<MergedScanConfig>& merged_keys();
const Keys<MergedCloudConfig>& merged_cloud_keys();
const Keys<VirtualScanConfig>& virtual_keys();
const Keys<BlackBoxConfig>& black_box_keys();
/// What holds for a virtual scan before its keys are read.
VirtualScanConfig default_virtual_scan();
/// The keys that merged and virtual scans share.
const Keys<OutputScanConfig>& output_keys();
/// Of an entry of `source_settings:` of a merged scan.
const Keys<SourceSettings>& source_keys();
/// The value of an entry of `also:`.
const KeyOf<AlsoScanConfig>& also_profile();

/// Keys of sensors that not every model takes.
struct SensorGroup {
  std::string_view models;      ///< that take it, for people; empty: all
  bool (*takes)(const Model&);  ///< nullptr: every sensor, also one with `topic:`
  bool network;                 ///< they mean nothing beside packet_topic
  Keys<SensorConfig> keys;
  std::string_view instead = "no such key";  ///< of other models
};
const std::vector<SensorGroup>& sensor_groups();
/// True if these keys mean something to the sensor.
bool takes(const SensorConfig& sensor, const SensorGroup& group);

/// Keys and their values as a text that parse_config() reads.
std::string yaml_text(const KeyMap& keys);

/// A number of a merged or virtual scan that nodes of ira_laser_tools let change at run time.
struct GridLimit {
  std::string_view name;
  double min, max;
  double preset;  ///< their default
};

/// ira_laser_tools 1.0.7, cfg/laserscan_multi_merger.cfg. Its virtualizer ends range_max at 50 m, which users
/// complained about (ira_laser_tools issue 10); 1000 m holds for both here.
constexpr GridLimit grid_limits[]{{"angle_min", -3.14159265358979323846, 3.14159265358979323846, -2.36},
                                  {"angle_max", -3.14159265358979323846, 3.14159265358979323846, 2.36},
                                  {"angle_increment", 0, 3.14159265358979323846, 0.0058},
                                  {"time_increment", 0, 1, 0},
                                  {"scan_time", 0, 1, 0.0333333},
                                  {"range_min", 0, 50, 0.45},
                                  {"range_max", 0, 1000, 25}};

constexpr const GridLimit* grid_limit(std::string_view name) {
  for (const GridLimit& limit : grid_limits) {
    if (limit.name == name) return &limit;
  }
  return nullptr;
}

}  // namespace lidard
