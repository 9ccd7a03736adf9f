// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "daemon/dropin/dropin_setup.h"
#include "daemon/dropin/node_parameters.h"

namespace lidard {

/// Translates the parameters of velodyne_driver's, velodyne_pointcloud's and velodyne_laserscan's nodes, with
/// their defaults. Throws ConfigError for a value that means nothing.
DropinSetup velodyne_node_setup(const NodeParameters& parameters);

}  // namespace lidard
