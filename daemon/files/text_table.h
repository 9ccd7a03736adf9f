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

}  // namespace lidard
