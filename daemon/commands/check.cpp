// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/commands/check.h"

#include <ostream>

#include "daemon/config/config.h"
#include "daemon/config/exit_codes.h"
#include "daemon/config/read_file.h"
#include "daemon/pipeline/forecast.h"

namespace lidard {
int run_check(const std::string& file, std::ostream& out, std::ostream& err) {
  try {
    const std::string text = read_file(file, "a readable YAML file");
    const Config config = parse_config(text, file);
    for (const std::string& warning : config.warnings) err << warning << '\n';
    for (const std::string& sentence : forecast(config, text)) err << sentence << '\n';
    out << to_yaml(config);
    return 0;
  } catch (const ConfigError& error) {
    err << error.what() << '\n';
    return exit_config;
  }
}

}  // namespace lidard
