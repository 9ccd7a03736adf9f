// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drivers/driver.h"
#include "drivers/key.h"

namespace lidard {

/// Permission to change settings of a device: Trait::settings_writable, receiver_settable, logins.
Keys<DeviceRequests> write_keys();
Keys<DeviceRequests> receiver_keys();
Keys<DeviceRequests> login_keys();

/// Parameters of the request for scans (REP 138): Trait::skip_request.
Keys<DeviceRequests> scip_keys();
/// Comparison of the host's and the device's clock.
Keys<DeviceRequests> scip_clock_keys();

/// Clock of a device with a satellite receiver: Trait::gnss.
Keys<DriverConfig> receiver_clock_keys();

/// Publication of the device's states: Trait::states_on_request.
Keys<DeviceRequests> state_keys();

/// Skipped scans: Trait::skip_setting, Trait::skip_request.
Keys<DeviceRequests> skip_keys();

/// Begin of a cloud in the stream, and its view and ranges: Trait::revolutions.
Keys<DriverConfig> revolution_keys();

}  // namespace lidard
