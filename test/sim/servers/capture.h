// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "test/sim/world/scene.h"

namespace lidard::sim {

/// What `make_capture` wrote.
struct CaptureSummary {
  std::uint64_t packets = 0;
  std::uint64_t measurements = 0;
};

/// Drives through the scene and writes PREFIX.pcap, PREFIX.truth (unless asked not to: the scene has the
/// truth as well) and PREFIX.odometry.csv if the scene has odometry. Throws std::runtime_error.
CaptureSummary make_capture(const Scene& scene, const std::string& prefix, bool with_truth = true);

}  // namespace lidard::sim
