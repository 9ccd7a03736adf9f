// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace lidard {

/// A function of one of the modules that need the Point Cloud Library, which are a package of their own
/// (lidard-pcl). A module is loaded when it is first asked for, and for good. Throws std::runtime_error that
/// begins with `purpose` and names the package if the module is not installed.
void* module_function(const std::string& module, const char* function, const std::string& purpose);

}  // namespace lidard
