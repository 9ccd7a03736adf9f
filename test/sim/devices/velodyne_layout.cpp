// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/devices/velodyne_layout.h"

#include <algorithm>
#include <cmath>

namespace lidard::sim {
namespace {

using Content = BlockPlan::Content;

constexpr std::size_t blocks = 12;
// Velodyne 63-9483 (VLS-128 User Manual): lasers 0..31, 32..63, 64..95, 96..127.
constexpr std::uint16_t flags[] = {0xeeff, 0xddff, 0xccff, 0xbbff};

BlockPlan single_block(std::size_t block, std::size_t banks, ReturnMode mode) {
  const Content content = mode == ReturnMode::last ? Content::last : Content::strongest;
  return {flags[block % banks], 32 * block, content, 0};
}

// Velodyne 63-9243 (VLP-16 User Manual) ch. 9.3, dual return.
BlockPlan dual_block(std::size_t block) {
  const bool odd = block % 2 == 1;
  return {flags[0], 32 * (block / 2), odd ? Content::second : Content::last,
          static_cast<std::uint8_t>(odd ? 1 : 0)};
}

// Upper and lower block of one return, then of the other; strongest first as velodyne_decoder reads it.
BlockPlan dual_block_64(std::size_t block) {
  const bool later = block % 4 >= 2;
  const std::size_t bank = block % 2;
  return {flags[bank], 64 * (block / 4) + 32 * bank, later ? Content::last : Content::second,
          static_cast<std::uint8_t>(later ? 1 : 0)};
}

// One sequence in eight blocks, and four that hold nothing (VeloView). Last first, as velodyne_decoder has
// it; UniBwTAS/velodyne calls the first one the strongest.
BlockPlan dual_block_128(std::size_t block) {
  if (block >= 8) return {0xffff, 0, Content::dummy, 0};
  BlockPlan plan = dual_block(block);
  plan.flag = flags[block / 2];
  return plan;
}

// Return 1, return 2 and the confidence of both per bank (UniBwTAS/velodyne, VeloView).
BlockPlan confidence_block(std::size_t block) {
  const std::size_t bank = block / 3;
  const Content contents[] = {Content::last, Content::second, Content::confidence};
  return {flags[bank], 32 * bank, contents[block % 3], static_cast<std::uint8_t>(block % 3)};
}

}  // namespace

std::vector<BlockPlan> plan_packet(std::size_t lasers, ReturnMode mode) {
  std::vector<BlockPlan> plan;
  const std::size_t banks = std::max<std::size_t>(1, lasers / 32);
  for (std::size_t block = 0; block < blocks; ++block) {
    if (mode == ReturnMode::dual_confidence) {
      plan.push_back(confidence_block(block));
    } else if (mode != ReturnMode::dual) {
      plan.push_back(single_block(block, banks, mode));
    } else {
      plan.push_back(banks == 1   ? dual_block(block)
                     : banks == 2 ? dual_block_64(block)
                                  : dual_block_128(block));
    }
  }
  return plan;
}

// Lower, upper, upper, upper, and so on: atwallshort.pcap of chalmers-revere/opendlv.core, all 306 packets.
std::size_t bank_of_sequence(std::size_t sequence) { return sequence % 4 == 0 ? 1 : 0; }

std::vector<BlockPlan> plan_bank_by_bank(ReturnMode mode) {
  std::vector<BlockPlan> plan;
  for (std::size_t block = 0; block < blocks; ++block) {
    plan.push_back(single_block(block, 1, mode));
    plan.back().flag = flags[bank_of_sequence(block)];
  }
  return plan;
}

std::uint32_t confidence_bits(double distance, double reflectivity) {
  // Bit 11 drop, 6:5 interference (3: none), 4:3 sun, 2:0 confidence (UniBwTAS/velodyne, README).
  if (!std::isfinite(distance)) return 1U << 11U;
  const auto confidence = static_cast<std::uint32_t>(std::lround(std::clamp(7 * reflectivity, 1.0, 7.0)));
  const auto far = static_cast<std::uint32_t>(std::min(3.0, distance / 5));
  return (3 - far) << 5U | far << 3U | confidence;
}

}  // namespace lidard::sim
