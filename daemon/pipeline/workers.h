// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "daemon/config/config.h"

namespace lidard {

/// Divides the work among the threads of a running daemon: sets SensorConfig::worker and
/// Config::cloud_worker. A planar scanner that is a source of a merged cloud, or shares a UDP port with a
/// multi-plane lidar, goes with the clouds. A replay has one thread and does without.
void assign_workers(Config& config);

/// True if the worker for clouds has something to receive.
bool has_clouds(const Config& config);

/// `vehicle:` as a worker needs it: without motion if only the other worker makes something of frames.
VehicleConfig vehicle_for(const Config& config, Worker worker);

}  // namespace lidard
