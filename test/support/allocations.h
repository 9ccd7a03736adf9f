// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

namespace lidard::test {

/// How often this thread has called operator new since it started.
std::uint64_t allocations();

/// What this process holds: bytes of memory in use, and open files.
std::size_t resident_bytes();
std::size_t open_files();

}  // namespace lidard::test
