// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

namespace lidard {

/// `lidard inspect`: which sensors are in the captures, how well they were recorded, and a configuration that
/// replays them. As text the whole output is such a configuration, the report being its comments; or JSON.
/// What is wrong with a capture goes to `err`. Returns the exit code: 0, or 1 if a capture could not be read
/// to its end.
int run_inspect(const std::vector<std::string>& captures, bool json, std::ostream& out, std::ostream& err);

}  // namespace lidard
