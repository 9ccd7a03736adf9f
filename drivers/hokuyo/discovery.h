// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drivers/discovery.h"

namespace lidard::hokuyo {

/// Asks a Hokuyo for its name (SCIP: VV).
const Discovery& discovery();

}  // namespace lidard::hokuyo
