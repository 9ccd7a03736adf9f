// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Compiled with -mavx2 on x86-64 (CMakeLists.txt); called only where the processor has it.
#include "drivers/velodyne/sequence_kernel.h"

#if defined(__AVX2__)
#include "drivers/velodyne/sequence_kernel_loops.h"
#endif

namespace lidard::velodyne {

const SequenceKernels* avx2_kernels() {
#if defined(__AVX2__)
  return &kernels;
#else
  return nullptr;
#endif
}

}  // namespace lidard::velodyne
