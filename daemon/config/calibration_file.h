// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "daemon/config/yaml.h"
#include "drivers/calibration_file.h"

namespace lidard {

/// Reads a calibration file as parse_calibration() does.
inline Calibration load_calibration(const std::string& path, std::vector<std::string>& warnings) {
  return parse_calibration(read_file(path, calibration_files), path, parse_yaml, warnings);
}

}  // namespace lidard
