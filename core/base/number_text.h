// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <charconv>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

namespace lidard {

/// The shortest decimal text that reads back to the same number, whatever the locale.
inline std::string number_text(double number) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, number == 0 ? 0.0 : number).ptr};
}

/// Parses all of `text`, without blanks, as a number; empty if it is none. An unsigned type has no sign.
template <class Number>
std::optional<Number> number_in(std::string_view text, [[maybe_unused]] int base = 10) {
  Number number{};
  const char* const end = text.data() + text.size();
  std::from_chars_result read{};
  if constexpr (std::is_floating_point_v<Number>)
    read = std::from_chars(text.data(), end, number, std::chars_format::general);
  else
    read = std::from_chars(text.data(), end, number, base);
  return read.ec == std::errc() && read.ptr == end ? std::optional<Number>(number) : std::nullopt;
}

/// Text as std::printf() writes it, for constant formats; at most 255 characters.
template <class... Values>
std::string printed(const char* format, Values... values) {
  char text[256];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

/// "3.142" for 3 digits after the point.
inline std::string fixed(double value, int digits) { return printed("%.*f", digits, value); }

}  // namespace lidard
