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

}  // namespace lidard
