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

/// Drives through the scene and writes PREFIX.pcap, PREFIX.truth (unless told not to: the scene tells the
/// truth as well), PREFIX.odometry.csv if the scene has odometry, and the lines about pcap and truth in
/// PREFIX.digest (other lines of that file stay). Throws std::runtime_error.
CaptureSummary make_capture(const Scene& scene, const std::string& prefix, bool with_truth = true);

/// CRC-32 (IEEE 802.3, as in zlib) of a file; throws std::runtime_error.
std::uint32_t file_crc32(const std::string& path);

}  // namespace lidard::sim
