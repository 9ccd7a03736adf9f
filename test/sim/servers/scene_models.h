// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "test/sim/world/sensor_model.h"
#include "test/sim/world/yaml_reader.h"

namespace lidard::sim {

/// A model that a scene may have: its name there, what limits its range, and how its options are read.
struct SceneModel {
  std::string name;
  double range_min, range_max;  ///< m
  /// Sets how a capture and, of a TCP sensor, how a server gets the device of `entry`.
  std::function<void(const YamlReader& options, SensorEntry& entry)> parse;
};

/// Those of each family.
std::vector<SceneModel> velodyne_models();
std::vector<SceneModel> safety_scanner_models();
std::vector<SceneModel> cola_models();
std::vector<SceneModel> hokuyo_models();
std::vector<SceneModel> sick_segment_models();

}  // namespace lidard::sim
