// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/check.h"

#include <ostream>

#include "daemon/config.h"

namespace lidard {
namespace {

constexpr int exit_config = 78;  // EX_CONFIG of sysexits.h

}  // namespace

int run_check(const std::string& file, std::ostream& out, std::ostream& err) {
  try {
    const Config config = load_config(file);
    for (const std::string& warning : config.warnings) err << warning << '\n';
    out << to_yaml(config);
    return 0;
  } catch (const ConfigError& error) {
    err << error.what() << '\n';
    return exit_config;
  }
}

}  // namespace lidard
