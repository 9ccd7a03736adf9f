// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "drivers/document.h"

namespace lidard {

/// Parses one YAML document; throws ConfigError for syntax errors and more than one document.
Value parse_yaml(const std::string& text, const std::string& file);

/// The content of a file of at most 1 MiB; throws ConfigError `path: what; expected …` with the expected kind
/// of file.
std::string read_file(const std::string& path, const std::string& expected);

}  // namespace lidard
