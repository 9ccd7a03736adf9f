// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace lidard {

/// A path with a number in it, as printf() has it: DIR/%06d.pcd.
class NumberedPath {
 public:
  /// Nothing if the path has no such place.
  static std::optional<NumberedPath> parse(const std::string& path) {
    for (auto at = path.find('%'); at != std::string::npos; at = path.find('%', at + 1)) {
      NumberedPath out;
      std::size_t end = at + 1;
      if (path[end] == '0') out.fill_ = '0', ++end;
      if (path[end] >= '1' && path[end] <= '9') out.width_ = static_cast<std::size_t>(path[end++] - '0');
      if (path[end] != 'd') continue;
      out.begin_ = path.substr(0, at);
      out.end_ = path.substr(end + 1);
      return out;
    }
    return std::nullopt;
  }
  std::string of(std::uint64_t number) const {
    const std::string digits = std::to_string(number);
    return begin_ + std::string(width_ > digits.size() ? width_ - digits.size() : 0, fill_) + digits + end_;
  }

 private:
  std::string begin_, end_;
  char fill_ = ' ';
  std::size_t width_ = 0;
};

}  // namespace lidard
