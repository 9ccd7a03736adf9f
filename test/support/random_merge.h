// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include "core/frames/cloud.h"
#include "core/merge/merger.h"
#include "core/mounts/mount_check.h"

namespace lidard::sim {

/// What a merge gave: scans in profiles strict, safety and flatten, the cloud, and the counters.
struct RandomMerge {
  const PlanarScan* scans;
  const Cloud& cloud;
  const Merger& merger;
  const MergeReport& report;
  const MountCheck& mounts;
};

/// Reads a merge's settings, sources, mounts and sweeps out of bytes, as a fuzzer or a generator of random
/// numbers makes them, and runs them through the whole merge. Returns the number of outputs; 0 also if the
/// bytes are too few. Aborts if an output breaks an invariant of scans.
/// `look` is shown each of them.
std::size_t merge_bytes(const std::uint8_t* data, std::size_t size,
                        const std::function<void(const RandomMerge&)>& look = {});

}  // namespace lidard::sim
