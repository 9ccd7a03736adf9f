// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Any text as the calibration of a Velodyne, YAML or db.xml. Corpus: config/velodyne; -max_len=16384.
#include <cmath>
#include <cstdlib>
#include <string>

#include "daemon/config/config.h"
#include "daemon/yaml/yaml.h"
#include "drivers/calibration_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lidard;
  std::vector<std::string> warnings;
  try {
    const auto calibration = parse_calibration(std::string(data, data + size), "text", parse_yaml, warnings);
    if (calibration.lasers.empty()) std::abort();
    for (const auto& laser : calibration.lasers) {
      if (!std::isfinite(laser.vert_correction) || !std::isfinite(laser.rot_correction)) std::abort();
    }
  } catch (const ConfigError& error) {
    if (std::string(error.what()).rfind("text:", 0) != 0) std::abort();
  }
  return 0;
}
