// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <charconv>
#include <cstdio>
#include <string>

namespace lidard {

/// The shortest decimal text that reads back to the same number, whatever the locale.
inline std::string number_text(double number) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, number == 0 ? 0.0 : number).ptr};
}

/// Text as std::printf() writes it, for constant formats; at most 255 characters.
template <class... Values>
std::string printed(const char* format, Values... values) {
  char text[256];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

}  // namespace lidard
