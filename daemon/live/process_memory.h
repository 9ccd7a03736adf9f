// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace lidard {

/// Lets clouds of 10 MB, which come and go ten times a second, have memory mappings of their own that are
/// returned to the system. In the heaps of several threads they would leave holes.
void keep_heap_small();
/// Locks the memory if $LIDARD_LOCK_MEMORY is set, since swapped memory delays a scan. Does nothing if the
/// process has a limit of locked memory, since later allocations would fail.
void lock_memory();

}  // namespace lidard
