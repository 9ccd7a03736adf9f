// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drivers/key.h"
#include "drivers/velodyne/web/velodyne_settings.h"

namespace lidard {

/// `control:` of a sensor: Trait::web_control.
Keys<VelodyneControl> control_keys();

}  // namespace lidard
