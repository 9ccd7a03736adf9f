// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>
#include <vector>

namespace lidard {

/// The names nearest to `name`, best first, at most three: for "did you mean".
std::vector<std::string_view> nearest_models(std::string_view name);

}  // namespace lidard
