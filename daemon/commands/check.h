// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <iosfwd>
#include <string>

namespace lidard {

/// `lidard check`: prints the configuration with every default filled in to `out`, remarks and errors to
/// `err`. Returns the exit code: 0, or 78 for a wrong configuration.
int run_check(const std::string& file, std::ostream& out, std::ostream& err);

}  // namespace lidard
