// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace lidard {

/// A function of one of the modules that hold what only some commands need and what brings many libraries
/// along. A module is loaded when it is first asked for, and for good. Throws std::runtime_error that begins
/// with `purpose` ("PCD files need …") if the module cannot be loaded.
void* module_function(const std::string& module, const char* function, const std::string& purpose);

}  // namespace lidard
