// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config/module.h"

#include <dlfcn.h>
#include <link.h>

#include <array>
#include <filesystem>
#include <stdexcept>

namespace lidard {
namespace {

namespace fs = std::filesystem;

/// Where modules are: in the build folder, and below lib/lidard after installation. Both as seen from the
/// program, or from the Python package, that this code is linked into.
std::array<fs::path, 2> module_folders() {
  Dl_info info{};
  link_map* self = nullptr;
  dladdr1(reinterpret_cast<const void*>(&module_function), &info, reinterpret_cast<void**>(&self),
          RTLD_DL_LINKMAP);
  // The program itself has no name there.
  if (self != nullptr && self->l_name != nullptr && *self->l_name != '\0') {
    const fs::path package = fs::canonical(self->l_name).parent_path();
    return {package / "../..", package / "../../../lidard/modules"};
  }
  const fs::path program = fs::read_symlink("/proc/self/exe").parent_path();
  return {program, program / "../lib/lidard/modules"};
}

}  // namespace

void* module_function(const std::string& module, const char* function, const std::string& purpose) {
  std::string trouble;
  for (const fs::path& folder : module_folders()) {
    void* const loaded = dlopen((folder / (module + ".so")).c_str(), RTLD_NOW | RTLD_LOCAL);
    void* const found = loaded == nullptr ? nullptr : dlsym(loaded, function);
    if (found != nullptr) return found;
    trouble = dlerror();
  }
  throw std::runtime_error(purpose + ": " + trouble);
}

}  // namespace lidard
