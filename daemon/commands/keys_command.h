// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <iosfwd>

namespace lidard {

/// How the reference of all configuration keys is printed: for a terminal, for config/KEYS.md, for the manual
/// page, or for programs.
enum class KeysFormat { table, markdown, man, json };

/// Prints it. Returns the exit code.
int run_keys(KeysFormat format, std::ostream& out);

}  // namespace lidard
