// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <ostream>
#include <string>
#include <vector>

namespace lidard {

/// Rows of cells; the first row has the headings.
using TextTable = std::vector<std::vector<std::string>>;

/// Prints a table in columns as wide as their longest cell; each line begins with `prefix`.
inline void print_columns(const TextTable& table, std::ostream& out, const std::string& prefix = "") {
  std::vector<std::size_t> widths(table.front().size());
  for (const auto& row : table) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  for (const auto& row : table) {
    std::string line = prefix;
    for (std::size_t i = 0; i < row.size(); ++i)
      line += row[i] + std::string(widths[i] - row[i].size() + 2, ' ');
    out << line.substr(0, line.find_last_not_of(' ') + 1) << '\n';
  }
}

/// The same for a terminal of 80 columns: the last cell goes on in further lines.
inline void print_narrow(const TextTable& table, std::ostream& out) {
  constexpr std::size_t width = 80, widest = 21;
  std::vector<std::size_t> begins(table.front().size(), 0);
  for (std::size_t i = 0; i + 1 < begins.size(); ++i) {
    std::size_t longest = 0;
    for (const auto& row : table) longest = std::max(longest, row[i].size());
    begins[i + 1] = begins[i] + std::min(longest, widest) + 2;
  }
  for (const auto& row : table) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string& cell = row[i];
      if (!line.empty() && line.size() + 2 > begins[i]) out << line << '\n', line.clear();
      line.resize(begins[i], ' ');
      std::size_t at = 0;
      const std::size_t room = width - begins[i];
      while (cell.size() - at > room) {
        const std::size_t blank = cell.rfind(' ', at + room);
        const std::size_t end = blank == std::string::npos || blank <= at ? at + room : blank;
        out << line << cell.substr(at, end - at) << '\n';
        line.assign(begins[i], ' ');
        at = end + (end == blank ? 1 : 0);
      }
      line += cell.substr(at);
    }
    out << line << '\n';
  }
}

}  // namespace lidard
