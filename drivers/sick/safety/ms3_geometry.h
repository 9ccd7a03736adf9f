// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/base/time.h"
#include "core/frames/scan.h"
#include "drivers/sick/safety/ms3_telegram.h"

namespace lidard::sick {

/// True if beams, angles and times are the same; the distance factor may differ.
bool same_geometry(const Ms3Derived& a, const Ms3Derived& b);
/// "48 beams from -10.5597 deg in steps of 0.51306 deg, 30 ms a scan".
std::string describe(const Ms3Derived& derived);
/// Time between neighbouring beams.
Span beam_period(const Ms3Derived& derived);
/// What the flags of a beam say of it.
BeamStatus status_of(Ms3Beam beam);

}  // namespace lidard::sick
