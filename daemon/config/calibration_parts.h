// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "drivers/velodyne/calibration.h"

namespace lidard {

constexpr long most_lasers = 128;
constexpr double finest_step_m = 0.001;  // what a distance step can be; a 0.2 is one in cm
constexpr double coarsest_step_m = 0.02;

/// Reads a db.xml; see parse_calibration().
velodyne::Calibration parse_calibration_xml(const std::string& text, const std::string& name,
                                            std::vector<std::string>& warnings);
/// The step to use instead of what a file says, with a warning: VLS-128 files in circulation say 7 mm where
/// the sensor counts in 4 mm.
double guarded_step(double step_m, std::size_t lasers, const std::string& place,
                    std::vector<std::string>& warnings);

}  // namespace lidard
