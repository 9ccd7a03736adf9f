// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <regex>
#include <string>

namespace lidard {

/// A path with a number in it, as printf() has it: DIR/%06d.pcd.
class NumberedPath {
 public:
  /// Nothing if the path has no such place.
  static std::optional<NumberedPath> parse(const std::string& path) {
    static const std::regex place("%(0?)([1-9]?)d");
    std::smatch found;
    if (!std::regex_search(path, found, place)) return std::nullopt;
    NumberedPath out;
    out.begin_ = found.prefix();
    out.end_ = found.suffix();
    out.fill_ = found[1].length() > 0 ? '0' : ' ';
    out.width_ = found[2].length() > 0 ? static_cast<std::size_t>(found[2].str()[0] - '0') : 0;
    return out;
  }
  std::string of(std::uint64_t number) const {
    const std::string digits = std::to_string(number);
    return begin_ + std::string(width_ > digits.size() ? width_ - digits.size() : 0, fill_) + digits + end_;
  }

 private:
  std::string begin_, end_;
  char fill_ = '0';
  std::size_t width_ = 0;
};

}  // namespace lidard
