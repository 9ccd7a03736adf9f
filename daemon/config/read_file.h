// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace lidard {

/// The content of a file of at most 1 MiB; throws ConfigError `path: what; expected …`, where `expected` says
/// what kind of file it should have been.
std::string read_file(const std::string& path, const std::string& expected);

}  // namespace lidard
