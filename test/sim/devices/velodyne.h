// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "test/sim/devices/velodyne_options.h"
#include "test/sim/devices/velodyne_tables.h"
#include "test/sim/world/sensor_model.h"

namespace lidard::sim {

/// The product's timing of that name; throws std::invalid_argument.
const VelodyneTiming& velodyne_timing(const VelodyneTable& table, const std::string& name);

/// A device of that product. The table must live on.
ModelMaker make_velodyne(const VelodyneTable& table, const VelodyneOptions& options);

}  // namespace lidard::sim
