// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/support/captures.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace lidard::test {

std::string shared_capture(const std::string& name) {
  const char* root = std::getenv("LIDARD_CAPTURES");
  if (root == nullptr) return {};
  const auto path = std::filesystem::path(root) / name;
  return std::filesystem::exists(path) ? path.string() : std::string();
}

std::string project_file(const std::string& name) { return std::string(LIDARD_SOURCE_DIR "/") + name; }

std::string content(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace lidard::test
