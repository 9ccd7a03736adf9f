// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config/module.h"

#include <dlfcn.h>

#include <filesystem>
#include <stdexcept>

namespace lidard {

/// Modules are beside the program in a build tree and below lib/lidard after installation.
void* module_function(const std::string& module, const char* function, const std::string& purpose) {
  const std::filesystem::path beside = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  std::string trouble;
  for (const auto& folder : {beside, beside / "../lib/lidard/modules"}) {
    void* const loaded = dlopen((folder / (module + ".so")).c_str(), RTLD_NOW | RTLD_LOCAL);
    void* const found = loaded == nullptr ? nullptr : dlsym(loaded, function);
    if (found != nullptr) return found;
    trouble = dlerror();
  }
  throw std::runtime_error(purpose + ": " + trouble);
}

}  // namespace lidard
