// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace lidard {

/// Prefers the calling thread, and those that it starts, to other programs, as far as the system permits: 10
/// steps of niceness, and from Linux 6.12 on a short slice, so that a thread of planar scanners need not wait
/// until a busy one has used up its own.
void prefer_this_thread();
/// Lets the calling thread give way again: clouds come after planar scanners.
void yield_this_thread();

}  // namespace lidard
