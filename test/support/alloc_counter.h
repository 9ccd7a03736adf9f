// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace lidard::test {

/// How often any `operator new` of this program was called so far, in all threads. Code that must not
/// allocate leaves the number as it was.
std::uint64_t allocations();

}  // namespace lidard::test
