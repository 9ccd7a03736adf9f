// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "test/sim/devices/scip_device.h"
#include "test/sim/devices/uam_device.h"
#include "test/sim/world/sensor_model.h"
#include "test/sim/world/yaml_reader.h"

namespace lidard::sim {

/// A Hokuyo of a scene: its name there, and how it makes itself.
struct HokuyoFamily {
  std::string name;
  double range_min, range_max;  ///< m
};
/// All of them.
std::vector<HokuyoFamily> hokuyo_families();
/// Reads the sensor's options; sets how a capture and how a server gets its device.
void parse_hokuyo(const std::string& model, const YamlReader& options, SensorEntry& entry);

}  // namespace lidard::sim
