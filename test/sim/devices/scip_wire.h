// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace lidard::sim {

/// One distance that a SCIP device measured.
struct ScipEcho {
  std::uint32_t distance_mm = 0;  ///< or a code
  std::uint32_t intensity = 0;
};
/// All echoes of one step, nearest first; at least one (a code counts).
using ScipStep = std::vector<ScipEcho>;

/// A line with its check character and LF.
std::string scip_line(std::string_view text);
/// `value` in `characters` characters of 6 bits.
std::string scip_code(std::uint64_t value, int characters);
/// Cuts data into lines of 64 characters, each with its check character.
std::string scip_block(std::string_view data);
/// A whole answer: echo, status, body, empty line.
std::string scip_answer(std::string_view echo, std::string_view status, std::string_view body = "");
/// Lines KEY:VALUE; with check characters.
std::string scip_entries(const std::vector<std::pair<std::string, std::string>>& entries);

/// A request for distances.
struct ScipOrder {
  std::string echo;  ///< without LF
  bool percent = false, continuous = false, multi_echo = false, intensities = false, short_values = false;
  int first = 0, last = 0, cluster = 1, skip = 0;
  int scans = 0;  ///< 0: endless
};
/// The distances of a sweep; `steps` begins with step 0 and holds at least last + 1 of them.
std::string scip_data(const ScipOrder& order, const std::vector<ScipStep>& steps);

}  // namespace lidard::sim
