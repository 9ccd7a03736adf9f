// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace lidard {

/// A function of a module. Modules contain parts with many libraries that only some commands need; a module
/// is loaded on first use and stays loaded. Throws std::runtime_error that begins with `purpose` ("PCD files
/// need …") if the module cannot be loaded.
void* module_function(const std::string& module, const char* function, const std::string& purpose);

}  // namespace lidard
