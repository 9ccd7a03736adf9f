// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

namespace lidard::sim {

/// Reads a merge's settings, sources, mounts and sweeps out of bytes, as a fuzzer or a generator of random
/// numbers makes them, and runs them through the whole merge. Returns the number of outputs; 0 also if the
/// bytes are too few. Aborts if an output breaks an invariant of scans.
std::size_t merge_bytes(const std::uint8_t* data, std::size_t size);

}  // namespace lidard::sim
