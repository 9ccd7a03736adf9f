// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/sequence_kernel.h"

#include "drivers/velodyne/sequence_kernel_loops.h"

namespace lidard::velodyne {

const SequenceKernels& portable_kernels() { return kernels; }

const SequenceKernels& best_kernels() {
#if defined(__x86_64__)
  static const bool has_avx2 = __builtin_cpu_supports("avx2");
  if (has_avx2 && avx2_kernels() != nullptr) return *avx2_kernels();
#endif
  return portable_kernels();
}

}  // namespace lidard::velodyne
