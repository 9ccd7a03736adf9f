// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "test/sim/world/sensor_model.h"
#include "test/sim/world/yaml_reader.h"

namespace lidard::sim {

/// Reads a scene file's `options` of a picoScan100 (`several_layers`: of a multiScan100).
ModelMaker parse_sick_segments(bool several_layers, const YamlReader& yaml);

}  // namespace lidard::sim
