// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <spdlog/fmt/fmt.h>

#include <charconv>
#include <cmath>
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
  /// With a fixed number of digits behind the point, as `{:.5f}`, but twice as fast as std::to_chars: the
  /// numbers of a lidar have few digits.
  template <int digits>
  RowText& fixed(double value) {
    constexpr std::int64_t one = power_of_ten(digits);
    const double scaled = std::abs(value) * static_cast<double>(one);
    const double whole = std::nearbyint(scaled);
    // Of a number in the middle between two the product may be rounded to the wrong side; inf and NaN are not
    // less than anything.
    const bool sure = scaled < 1e9 && std::abs(scaled - whole) < 0.5 - 1e-6;
    if (!sure) return number(value, std::chars_format::fixed, digits);
    if (std::signbit(value)) put('-');
    const auto units = static_cast<std::int64_t>(whole);
    integer(units / one).put('.');
    char behind[digits];
    std::int64_t rest = units % one;
    for (int i = digits; i-- > 0; rest /= 10) behind[i] = static_cast<char>('0' + rest % 10);
    return put({behind, digits});
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
  static constexpr std::int64_t power_of_ten(int n) { return n == 0 ? 1 : 10 * power_of_ten(n - 1); }
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
