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
const Keys<VirtualScanConfig>& virtual_keys();
/// What holds for a virtual scan before its keys are read.
VirtualScanConfig default_virtual_scan();
/// The keys that merged and virtual scans share.
const Keys<OutputScanConfig>& output_keys();
/// Of an entry of `source_settings:` of a merged scan.
const Keys<SourceSettings>& source_keys();
/// Of an entry of `also:`, which may be written as its profile alone.
const KeyOf<AlsoScanConfig>& also_key();

/// Keys of sensors that not every model takes.
struct SensorGroup {
  std::string_view models;      ///< that take it, for people; empty: all
  bool (*takes)(const Model&);  ///< nullptr: every sensor, also one with `topic:`
  bool network;                 ///< they mean nothing beside packet_topic
  Keys<SensorConfig> keys;
  Misfit of_scanners{}, of_clouds{};  ///< why other models refuse them, and what to do instead
};
const std::vector<SensorGroup>& sensor_groups();
/// True if these keys mean something to the sensor.
bool takes(const SensorConfig& sensor, const SensorGroup& group);

/// Keys and their values as a text that parse_config() reads.
std::string yaml_text(const KeyMap& keys);

}  // namespace lidard
