// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace lidard {

/// Clouds of 10 MB come and go ten times a second. Each gets memory of its own, which the system has back
/// after it; in the heaps of several threads they would leave holes.
void keep_heap_small();
/// Where $LIDARD_LOCK_MEMORY asks for it: memory that is swapped out is late. Below a limit nothing is
/// locked, since what is allocated later would fail there.
void lock_memory();

}  // namespace lidard
