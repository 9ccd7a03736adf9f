// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "daemon/dropin/dropin_setup.h"
#include "daemon/dropin/node_parameters.h"

namespace lidard {

/// Translates the parameters of laserscan_multi_merger (ira_laser_tools 1.0.7), with its defaults and limits.
/// Throws ConfigError for what cannot be.
DropinSetup laser_merger_setup(const NodeParameters& parameters);
/// Translates the parameters of laserscan_virtualizer; throws ConfigError for what cannot be.
DropinSetup laser_virtualizer_setup(const NodeParameters& parameters);

/// laserscan_virtualizer reads four of its parameters from /laserscan_virtualizer whatever its own name is;
/// those stand in here for private ones that are not set.
NodeParameters with_absolute_names(NodeParameters own, const NodeParameters& absolute);

}  // namespace lidard
