// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "test/sim/world/sensor_model.h"
#include "test/sim/world/yaml_reader.h"

namespace lidard::sim {

/// A SICK scanner of a scene that speaks CoLa: its name there, and what limits its range.
struct ColaFamily {
  std::string name;
  double range_min, range_max;  ///< m
};
/// All of them.
std::vector<ColaFamily> cola_families();
/// Reads the sensor's options; sets how a capture and how a server gets its device.
void parse_cola(const std::string& model, const YamlReader& options, SensorEntry& entry);

}  // namespace lidard::sim
