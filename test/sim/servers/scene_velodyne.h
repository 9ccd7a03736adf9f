// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "test/sim/devices/velodyne.h"
#include "test/sim/world/yaml_reader.h"

namespace lidard::sim {

/// Reads a scene file's `options` of that product; complains where they do not fit it.
ModelMaker parse_velodyne(const VelodyneTable& table, const YamlReader& yaml);

}  // namespace lidard::sim
