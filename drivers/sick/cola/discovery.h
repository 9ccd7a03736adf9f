// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drivers/discovery.h"

namespace lidard::sick {

/// The search telegram of SICK devices (UDP 30718, as sick_scan_xd sends it; unverified on a device): 24
/// bytes; the answer is XML.
const Discovery& discovery();

}  // namespace lidard::sick
