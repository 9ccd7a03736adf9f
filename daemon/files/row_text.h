// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <spdlog/fmt/fmt.h>

#include <charconv>
#include <cstdint>
#include <iterator>
#include <string_view>
#include <type_traits>

#include "daemon/files/text_file.h"

namespace lidard {

/// Rows of numbers as text.
class RowText {
 public:
  explicit RowText(const std::string& path) : file_(path) {}

  RowText& put(std::string_view text) {
    text_.append(text.data(), text.data() + text.size());
    return *this;
  }
  RowText& put(char c) {
    text_.push_back(c);
    return *this;
  }
  template <class Integer>
  RowText& integer(Integer value) {
    static_assert(std::is_integral_v<Integer>);
    char digits[24];
    return put({digits,
                static_cast<std::size_t>(std::to_chars(digits, digits + sizeof digits, value).ptr - digits)});
  }
  /// With a fixed number of digits behind the point, as `{:.5f}`.
  template <int digits>
  RowText& fixed(double value) {
    return number(value, std::chars_format::fixed, digits);
  }
  /// As `{:g}`.
  RowText& shortest(float value) { return number(value, std::chars_format::general, 6); }
  template <class... Values>
  RowText& general(const char* format, const Values&... values) {
    fmt::format_to(std::back_inserter(text_), fmt::runtime(format), values...);
    return *this;
  }

  /// Call it now and then, so that the buffer stays small.
  void flush_if_long() {
    constexpr std::size_t enough = 256 * 1024UL;
    if (text_.size() >= enough) flush();
  }
  void close() {
    flush();
    file_.close();
  }

 private:
  template <class Number>
  RowText& number(Number value, std::chars_format format, int digits) {
    char text[512];  // the largest double has 309 digits before the point
    const char* const end = std::to_chars(text, text + sizeof text, value, format, digits).ptr;
    return put({text, static_cast<std::size_t>(end - text)});
  }
  void flush() {
    file_.write({text_.data(), text_.size()});
    text_.clear();
  }

  TextFile file_;
  fmt::memory_buffer text_;
};

}  // namespace lidard
