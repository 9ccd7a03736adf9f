// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

namespace lidard {

/// The program that `executable` (argv[0] without folder) stands for, a node of another package: reads that
/// node's private parameters from the master, for which it waits, and publishes what it did. Returns the exit
/// code. Empty: it is `lidard` itself.
std::function<int(const std::vector<std::string>& arguments, std::ostream& out, std::ostream& err)>
find_dropin(const std::string& executable);

}  // namespace lidard
