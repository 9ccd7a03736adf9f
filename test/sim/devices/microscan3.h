// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "test/sim/devices/safety_settings.h"
#include "test/sim/world/sensor_model.h"

namespace lidard::sim {

/// How a SICK safety scanner is set up. Angles as the device counts them: 0 to the right, counter-clockwise,
/// so that the front is 90 deg.
struct MicroScan3Options {
  double start_deg = -47.5;
  double end_deg = 227.5;        ///< the last beam lies at most here
  double resolution_deg = 0.39;  ///< rounded to 1/4194304 deg, the unit on the wire
  Span scan_time{30'000'000};    ///< one turn
  std::uint32_t serial = 12345678;
  std::uint32_t first_scan = 1;
  double protective_field = 0;  ///< m; beams nearer than that are marked in the intrusion data; 0 none
  std::vector<std::pair<double, double>> dirty_deg;  ///< sectors of the window that are contaminated
};

/// microScan3, nanoScan3, outdoorScan3. The layout is that of SICK 8022708 (pages stand beside the code), the
/// order and sizes of the blocks those of a recorded microScan3 (microscan3_398). Bits 6 and 7 of a beam's
/// status, which that one sets and nobody documents, are 0 here.
ModelMaker make_microscan3(const MicroScan3Options& options);
/// What such a scanner shows on its CoLa 2 port while it sends to `entry.to`.
SafetySettings safety_settings(const MicroScan3Options& options, const SensorEntry& entry);

}  // namespace lidard::sim
