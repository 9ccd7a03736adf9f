// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drivers/driver.h"
#include "drivers/key.h"

namespace lidard {

/// How a cloud is cut out of the stream, and which returns are kept: Trait::revolutions.
Keys<DriverConfig> revolution_keys();

}  // namespace lidard
