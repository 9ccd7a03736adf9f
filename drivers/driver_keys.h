// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drivers/driver.h"
#include "drivers/key.h"

namespace lidard {

/// What may be changed in a device: Trait::settings_writable, receiver_settable, logins.
Keys<DeviceRequests> write_keys();
Keys<DeviceRequests> receiver_keys();
Keys<DeviceRequests> login_keys();

/// What the request for scans says (REP 138): Trait::skip_request.
Keys<DeviceRequests> scip_keys();
/// How both clocks are compared.
Keys<DeviceRequests> scip_clock_keys();

/// What the clock of a device with a satellite receiver is meant to be: Trait::gnss.
Keys<DriverConfig> receiver_clock_keys();

/// Whether its states are published: Trait::states_on_request.
Keys<DeviceRequests> state_keys();

/// How many scans are left out: Trait::skip_setting, Trait::skip_request.
Keys<DeviceRequests> skip_keys();

/// How a cloud is cut out of the stream, and which returns are kept: Trait::revolutions.
Keys<DriverConfig> revolution_keys();

}  // namespace lidard
