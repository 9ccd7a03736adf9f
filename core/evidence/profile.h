// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace lidard {

/// How a scan says what is known. `strict`: only what is proven. `safety`: every return, and free only what
/// is proven free. `flatten`: points alone, as ira_laser_tools has it.
enum class Profile : std::uint8_t { strict, safety, flatten };

}  // namespace lidard
