// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "drivers/velodyne/web/velodyne_settings.h"

namespace lidard {

/// One voltage, current or temperature of the sensor's boards.
struct VelodyneReading {
  const char* name;  ///< "Top temperature"
  const char* unit;  ///< "C", "V", "A"
  double value;
  double lowest, highest;  ///< where the manual wants it
  bool judged;             ///< false: means nothing while the laser is off

  bool is_good() const { return !judged || (value >= lowest && value <= highest); }
};

/// The readings in `tree` ("diag.volt_temp…") in physical units; what is missing or no 12-bit count is left
/// out.
std::vector<VelodyneReading> velodyne_readings(const VelodyneTree& tree);

}  // namespace lidard
