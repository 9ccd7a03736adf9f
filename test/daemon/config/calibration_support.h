// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/offline/choice.h"
#include "daemon/yaml/yaml.h"
#include "drivers/calibration_file.h"

namespace lidard::test {

/// The calibration in `text`, as the file "f".
inline Calibration calibration_of(const std::string& text) {
  std::vector<std::string> warnings;
  return parse_calibration(text, "f", parse_yaml, warnings);
}

inline std::vector<std::string> calibration_warnings(const std::string& text) {
  std::vector<std::string> warnings;
  parse_calibration(text, "f", parse_yaml, warnings);
  return warnings;
}

/// The message of the mistake in `text`, as the file "f"; "no error" if there is none.
inline std::string calibration_error(const std::string& text) {
  try {
    calibration_of(text);
    return "no error";
  } catch (const ConfigError& error) {
    return error.what();
  }
}

}  // namespace lidard::test
