// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drivers/driver.h"
#include "drivers/key.h"

namespace lidard {

/// What a device is asked for: Trait::skip_setting.
Keys<DeviceRequests> cola_keys();

}  // namespace lidard
