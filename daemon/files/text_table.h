// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <ostream>
#include <string>
#include <vector>

#include "daemon/config/yaml_reader.h"

namespace lidard {

/// Rows of cells; the first row has the headings.
using TextTable = std::vector<std::vector<std::string>>;

/// A value of a report as one line of text; nothing known: "-".
inline std::string cell(const nlohmann::ordered_json& value) {
  if (value.is_null() || value == "") return "-";
  if (value.is_number_float()) return fmt::format("{:.4g}", value.get<double>());
  return printable(value.is_string() ? value.get<std::string>() : value.dump());
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
