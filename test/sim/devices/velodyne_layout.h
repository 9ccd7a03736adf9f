// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace lidard::sim {

enum class ReturnMode : std::uint8_t { strongest, last, dual, dual_confidence };

/// What a block of a packet holds.
struct BlockPlan {
  enum class Content : std::uint8_t { strongest, last, second, confidence, dummy };
  std::uint16_t flag;      ///< first two bytes, little-endian
  std::size_t first_beam;  ///< of 32 consecutive ones in the packet
  Content content;         ///< `second`: strongest, or second strongest where the strongest is the last
  std::uint8_t echo;       ///< which of the returns of a beam, in the order of the wire
};

/// The 12 blocks of a packet of a head with so many lasers.
std::vector<BlockPlan> plan_packet(std::size_t lasers, ReturnMode mode);
/// Those of an HDL-64E S1, where each block is a firing sequence.
std::vector<BlockPlan> plan_bank_by_bank(ReturnMode mode);
/// Its bank that fires in that sequence of a packet: 0 the upper, 1 the lower one.
std::size_t bank_of_sequence(std::size_t sequence);

/// The firing sequences that share one azimuth on the wire: two on a head of 16 lasers.
inline std::size_t sequences_per_azimuth(std::size_t lasers) { return lasers < 32 ? 32 / lasers : 1; }

/// Half a confidence word for a return at that exact distance (m; +inf: none): the 12 bits as they stand for
/// return 1. An invented sensor's judgement: a return is doubted the more the farther and darker it is.
std::uint32_t confidence_bits(double distance, double reflectivity);

}  // namespace lidard::sim
