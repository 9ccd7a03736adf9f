// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace lidard {

/// Asks for short slices for the calling thread and those that it starts (Linux 6.12, where the system
/// permits it): a thread that has little to do need not wait until a busy one has used up its slice. Older
/// kernels let it run at once anyway. The thread gets no larger share of the processors, so it cannot starve
/// others.
void prefer_this_thread();
/// Returns the calling thread to usual slices: clouds come after planar scanners.
void yield_this_thread();

/// Sets the name that `top -H` shows for the calling thread; at most 15 characters.
void name_this_thread(const char* name);

}  // namespace lidard
