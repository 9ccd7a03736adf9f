// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/process_memory.h"

#include <linux/capability.h>
#include <malloc.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdlib>
#include <string_view>

#include "daemon/log/log.h"

namespace lidard {

void keep_heap_small() {
  mallopt(M_MMAP_THRESHOLD, 1 << 20);
  mallopt(M_ARENA_MAX, 2);
}

void lock_memory() {
  const char* const requested = std::getenv("LIDARD_LOCK_MEMORY");
  if (requested == nullptr || std::string_view(requested) != "1") return;
  rlimit limit{};
  getrlimit(RLIMIT_MEMLOCK, &limit);
  const bool root = geteuid() == 0 && prctl(PR_CAPBSET_READ, CAP_IPC_LOCK) == 1;
  if ((root || limit.rlim_cur == RLIM_INFINITY) && mlockall(MCL_CURRENT | MCL_FUTURE) == 0) return;
  log_warn(
      "LIDARD_LOCK_MEMORY=1, but this process may not lock all of its memory; set "
      "LimitMEMLOCK=infinity in the unit");
}

}  // namespace lidard
