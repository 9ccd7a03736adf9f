// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "drivers/driver.h"
#include "drivers/hokuyo/scip_message.h"
#include "drivers/hokuyo/scip_parameters.h"

namespace lidard::hokuyo {

/// What to ask a sensor for: the steps inside the configured angles (all of them if there are none), cluster
/// and skip.
ScipScanRequest request_for(const ScipParameters& parameters, const DriverConfig& config);
/// True for UST firmware that knows the % extension: from 4.1, or from 1.1 within 1.x (as urg_stamped has
/// it).
bool firmware_knows_percent(const std::string& firmware);

}  // namespace lidard::hokuyo
