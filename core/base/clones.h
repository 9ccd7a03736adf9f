// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Compiles a function of vectorised loops once for any processor and once for AVX2; the dynamic linker
/// chooses. The results are equal to the last bit: AVX2 does not imply fused multiply-add. Not with
/// sanitizers, whose code the choice would run before the sanitizer is set up.
#if defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && \
    !defined(__clang__)
#define LIDARD_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define LIDARD_CLONES
#endif
