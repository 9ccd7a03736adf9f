// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/devices/scip_wire.h"

#include <algorithm>

namespace lidard::sim {
namespace {

constexpr std::size_t line_length = 64;  // Hokuyo C-42-03320B p. 11

char check_of(std::string_view text) {
  unsigned sum = 0;
  for (const char c : text) sum += static_cast<unsigned char>(c);
  return static_cast<char>(0x30U + sum % 64);
}

void put(const ScipOrder& order, const ScipEcho& echo, std::string& data) {
  const std::uint32_t longest = order.short_values ? 4095 : (1U << 18U) - 1;
  data += scip_code(std::min(echo.distance_mm, longest), order.short_values ? 2 : 3);
  if (order.intensities) data += scip_code(echo.intensity, 3);
}

/// A group's value is its least distance; codes count as the numbers they are.
const ScipStep& nearest(const std::vector<ScipStep>& steps, int first, int last) {
  const auto from = steps.begin() + first;
  return *std::min_element(from, steps.begin() + last + 1, [](const ScipStep& a, const ScipStep& b) {
    return a.front().distance_mm < b.front().distance_mm;
  });
}

}  // namespace

std::string scip_line(std::string_view text) { return std::string(text) + check_of(text) + '\n'; }

std::string scip_code(std::uint64_t value, int characters) {
  std::string text(static_cast<std::size_t>(characters), '0');
  for (auto at = text.rbegin(); at != text.rend(); ++at, value /= 64)
    *at = static_cast<char>(0x30U + value % 64);
  return text;
}

std::string scip_block(std::string_view data) {
  std::string lines;
  for (std::size_t at = 0; at < data.size(); at += line_length)
    lines += scip_line(data.substr(at, line_length));
  return lines;
}

std::string scip_answer(std::string_view echo, std::string_view status, std::string_view body) {
  return std::string(echo) + '\n' + scip_line(status) + std::string(body) + '\n';
}

std::string scip_entries(const std::vector<std::pair<std::string, std::string>>& entries) {
  std::string lines;
  for (const auto& [key, value] : entries) {
    const std::string text = key + ":" + value;
    lines += text + ";" + check_of(text) + "\n";
  }
  return lines;
}

std::string scip_data(const ScipOrder& order, const std::vector<ScipStep>& steps) {
  std::string data;
  for (int step = order.first; step <= order.last; step += order.cluster) {
    const ScipStep& value = nearest(steps, step, std::min(step + order.cluster - 1, order.last));
    put(order, value.front(), data);
    for (std::size_t i = 1; order.multi_echo && i < value.size(); ++i) {
      data += '&';
      put(order, value[i], data);
    }
  }
  return scip_block(data);
}

}  // namespace lidard::sim
