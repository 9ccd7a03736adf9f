// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "daemon/config/config.h"
#include "drivers/flow.h"

namespace lidard {

/// What comes from a sensor over the network, its data first; without an address in a flow where anybody may
/// send it.
std::vector<Flow> flows_of(const SensorConfig& sensor);

}  // namespace lidard
