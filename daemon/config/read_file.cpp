// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config/read_file.h"

#include <cerrno>
#include <cstring>
#include <fstream>

#include "daemon/config/config.h"

namespace lidard {
namespace {

// A configuration is a few kB, a calibration some 100 kB.
constexpr std::size_t largest_file = 1U << 20U;  // bytes

}  // namespace

std::string read_file(const std::string& path, const std::string& expected) {
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  std::string text;
  if (file) {
    text.resize(largest_file + 1);
    file.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(file.gcount()));
  }
  if (!file.is_open() || file.bad() || (file.fail() && !file.eof()))
    throw ConfigError(path + ": cannot be read: " + std::strerror(errno != 0 ? errno : EIO) + "; expected " +
                      expected);
  if (text.size() > largest_file) throw ConfigError(path + ": is larger than 1 MiB; expected " + expected);
  return text;
}

}  // namespace lidard
