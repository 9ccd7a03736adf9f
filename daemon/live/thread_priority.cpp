// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/thread_priority.h"

#include <pthread.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstdint>

namespace lidard {
namespace {

constexpr std::uint64_t short_slice_ns = 100'000, usual_slice = 0;

/// struct sched_attr of sched_setattr(2), which the C library has from version 2.41 on.
struct Attributes {
  std::uint32_t size = sizeof(Attributes), policy = SCHED_OTHER;
  std::uint64_t flags = 0;
  std::int32_t nice = 0;
  std::uint32_t priority = 0;
  std::uint64_t runtime = 0, deadline = 0, period = 0;  // ns; runtime: the slice, Linux 6.12
};

/// A policy that the user has set, as real time, stays, and so does the niceness.
void set_slice(std::uint64_t ns) {
  if (sched_getscheduler(0) != SCHED_OTHER) return;
  Attributes wanted;
  wanted.nice = getpriority(PRIO_PROCESS, 0);
  wanted.runtime = ns;
  syscall(SYS_sched_setattr, 0, &wanted, 0U);
}

}  // namespace

void prefer_this_thread() { set_slice(short_slice_ns); }
void yield_this_thread() { set_slice(usual_slice); }

void name_this_thread(const char* name) { pthread_setname_np(pthread_self(), name); }

}  // namespace lidard
