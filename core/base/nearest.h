// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

namespace lidard {

/// The least number of inserted, deleted, replaced or swapped neighbouring characters that makes `a` from
/// `b`.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// True if `written` may stand for a word at edit distance `distance`: a third of the letters may be wrong,
/// two in short words.
bool is_plausible_slip(std::string_view written, std::size_t distance);

/// The candidate nearest to `written`, the first of equals; empty if there is none or none is plausible.
std::string_view nearest_word(std::string_view written, const std::vector<std::string_view>& candidates);

}  // namespace lidard
