// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace lidard {

/// Allocates clouds (10 MB, ten times per second) as separate mappings that return to the system, since they
/// would leave holes in the heaps of several threads.
void keep_heap_small();
/// Locks the memory if $LIDARD_LOCK_MEMORY is 1, since swapped memory delays scans. Does nothing if locked
/// memory is limited, since later allocations would fail.
void lock_memory();

}  // namespace lidard
