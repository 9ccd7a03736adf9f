// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>

namespace lidard {

/// A mistake in the configuration: `file:line:column: what; expected …`. Exit code 78.
class ConfigError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A place in a file; line and column count from 1.
struct Place {
  std::string file;
  int line = 1;
  int column = 1;

  /// "file:line:column".
  std::string to_string() const { return file + ":" + std::to_string(line) + ":" + std::to_string(column); }
};

}  // namespace lidard
