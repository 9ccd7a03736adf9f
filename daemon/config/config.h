// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <set>
#include <string>
#include <vector>

#include "core/motion/frame_tree.h"
#include "daemon/config/black_box.h"
#include "daemon/config/merged_clouds.h"
#include "daemon/config/merged_scans.h"
#include "daemon/config/sensors.h"
#include "daemon/config/topic.h"
#include "daemon/config/vehicle.h"
#include "daemon/config/virtual_scans.h"
#include "drivers/config_error.h"

namespace lidard {

/// The whole configuration, complete and validated.
struct Config {
  std::string file;
  std::string text;  ///< of the file
  VehicleConfig vehicle;
  std::vector<SensorConfig> sensors;
  std::vector<MergedScanConfig> merged_scans;
  std::vector<MergedCloudConfig> merged_clouds;
  std::vector<VirtualScanConfig> virtual_scans;
  BlackBoxConfig black_box;
  std::vector<std::string> warnings;  ///< `file:line:column: what`, to be shown once
  /// What a part of a configuration must know of the other parts; a file has none.
  struct Elsewhere {
    std::vector<StaticTransform> poses;  ///< of all parts
    std::set<std::string> merged;        ///< sources here whose scans another part merges
    bool has_sensors = false;
  };
  Elsewhere elsewhere;

  const SensorConfig* find_sensor(const std::string& name) const;
  /// The lidars behind the cloud_topic of a virtual scan: one, or those of a merged cloud.
  std::vector<std::string> lidars_of(const VirtualScanConfig& group) const;
};

/// Reads and validates a configuration file; throws ConfigError.
Config load_config(const std::string& path);
/// The same from text; `name` stands in messages where a file name would.
Config parse_config(const std::string& text, const std::string& name);
/// The configuration as YAML with every default filled in; parse_config() reads it back to the same.
std::string to_yaml(const Config& config);
/// True if two entries have the same name and the same value of every key, so that they do the same.
bool operator==(const VehicleConfig& a, const VehicleConfig& b);
bool operator==(const SensorConfig& a, const SensorConfig& b);
bool operator==(const MergedScanConfig& a, const MergedScanConfig& b);
bool operator==(const MergedCloudConfig& a, const MergedCloudConfig& b);
bool operator==(const VirtualScanConfig& a, const VirtualScanConfig& b);

/// The poses that a configuration fixes, each frame once, for /tf_static too.
std::vector<StaticTransform> fixed_poses(const Config& config);

/// Everything that the configuration may publish on. At run time a topic travels as its entry of this list.
std::vector<OutputTopic> output_topics(const Config& config);

/// An entry of merged_scans:, merged_clouds: or virtual_scans: of the configuration, which makes scans or
/// clouds.
struct MakerId {
  enum class Kind : std::uint8_t { merged, merged_cloud, virtual_group };
  Kind kind = Kind::merged;
  std::string entry;

  friend bool operator==(const MakerId& a, const MakerId& b) {
    return a.kind == b.kind && a.entry == b.entry;
  }
};

/// Keys and their values as a text that parse_config() reads.
std::string yaml_text(const KeyMap& keys);

}  // namespace lidard
