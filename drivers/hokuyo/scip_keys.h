// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drivers/driver.h"
#include "drivers/key.h"

namespace lidard {

/// What the request for scans says (REP 138): Trait::skip_request.
Keys<DeviceRequests> scip_keys();
/// How both clocks are compared.
Keys<DeviceRequests> scip_clock_keys();

}  // namespace lidard
