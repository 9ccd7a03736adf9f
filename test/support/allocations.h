// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace lidard::test {

/// How often this thread has called operator new since it started.
std::uint64_t allocations();

}  // namespace lidard::test
