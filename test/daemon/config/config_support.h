// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "daemon/config/config.h"

namespace lidard::test {

/// The message of the mistake in `text`, as the file "f"; "no error" if there is none.
inline std::string error_of(const std::string& text) {
  try {
    parse_config(text, "f");
    return "no error";
  } catch (const ConfigError& error) {
    return error.what();
  }
}

/// One VLP-16 named roof and a topic source named rear, in lines 1 to 5.
inline const std::string roof_and_rear =
    "sensors:\n"
    "  roof:\n"
    "    model: velodyne_vlp16\n"
    "  rear:\n"
    "    topic: /rear/scan\n";

/// The message for a merged scan `m` with these keys in flow style; they begin at line 7, column 8.
inline std::string merged_error(const std::string& keys) {
  return error_of(roof_and_rear + "merged_scans:\n  m: {" + keys + "}\n");
}

/// The message for a virtual scan `v` with these keys in flow style; they begin at line 7, column 8.
inline std::string virtual_error(const std::string& keys) {
  return error_of(roof_and_rear + "virtual_scans:\n  v: {" + keys + "}\n");
}

}  // namespace lidard::test
