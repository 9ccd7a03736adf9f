// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <ostream>
#include <string>
#include <vector>

#include "drivers/document.h"

namespace lidard {

/// Rows of cells; the first row has the headings.
using TextTable = std::vector<std::vector<std::string>>;

/// A value of a report as one line of text, a number with 4 digits; nothing known: "-".
inline std::string cell(const nlohmann::ordered_json& value) {
  if (value.is_number_float()) return fmt::format("{:.4g}", value.get<double>());
  const std::string text = value.is_string() ? value.get<std::string>() : value.is_null() ? "" : value.dump();
  return text.empty() ? "-" : printable(text);
}

/// A list of objects as a table with a column for each of these members.
inline TextTable table_of(const nlohmann::ordered_json& list, const std::vector<const char*>& members) {
  TextTable table{{members.begin(), members.end()}};
  for (const auto& one : list) {
    table.emplace_back();
    for (const char* member : members)
      table.back().push_back(cell(one.value(member, nlohmann::ordered_json())));
  }
  return table;
}

/// Prints a table in columns as wide as their longest cell; each line begins with `prefix`. With `width`, no
/// line is longer: the last cell goes on in further lines, and a cell of more than `widest` characters has a
/// line of its own.
inline void print_columns(const TextTable& table, std::ostream& out, const std::string& prefix = "",
                          std::size_t width = 0, std::size_t widest = 21) {
  std::vector<std::size_t> begins(table.front().size(), prefix.size());
  for (std::size_t i = 0; i + 1 < begins.size(); ++i) {
    std::size_t longest = 0;
    for (const auto& row : table) longest = std::max(longest, row[i].size());
    begins[i + 1] = begins[i] + (width > 0 ? std::min(longest, widest) : longest) + 2;
  }
  for (const auto& row : table) {
    std::string line = prefix;
    const auto end_line = [&] {
      out << line.substr(0, line.find_last_not_of(' ') + 1) << '\n';
      line = prefix;
    };
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (i > 0 && line.size() + 2 > begins[i]) end_line();
      line.resize(begins[i], ' ');
      std::string rest = row[i];
      const std::size_t room = width > begins[i] ? width - begins[i] : rest.size();
      while (rest.size() > room) {
        const std::size_t blank = rest.rfind(' ', room);
        const bool is_split = blank != std::string::npos && blank > 0;
        line += rest.substr(0, is_split ? blank : room);
        rest.erase(0, is_split ? blank + 1 : room);
        end_line();
        line.resize(begins[i], ' ');
      }
      line += rest;
    }
    end_line();
  }
}

}  // namespace lidard
