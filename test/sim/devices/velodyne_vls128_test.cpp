// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "test/sim/devices/velodyne_testing.h"

namespace {

using namespace lidard;
using namespace lidard::sim;

TEST(VirtualVls128, FourBanksHoldASequenceOfSixteenGroups) {
  const struct {
    const char* timing;
    std::int64_t slot_64, slot_127, sequence, lag;
  } rows[] = {{"a", 9 * 2'665, 16 * 2'665, 53'300, 8'700},
              {"b", 26'667, 45'333, 53'333 + 1'941, 7'000},
              {"c", 10 * 2'890, 17 * 2'890, 57'800, 7'000}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.timing);
    VelodyneSetup setup = setup_of("velodyne_vls128");
    setup.timing = row.timing;
    setup.rest_spread_us = 0;
    const auto packets = simulate_velodyne(setup);
    EXPECT_THAT(flags(packets[0]), testing::ElementsAre(0xeeff, 0xddff, 0xccff, 0xbbff, 0xeeff, 0xddff,
                                                        0xccff, 0xbbff, 0xeeff, 0xddff, 0xccff, 0xbbff));
    EXPECT_THAT(azimuths(packets[0]), testing::ElementsAre(0, 0, 0, 0, 20, 20, 20, 20, 40, 40, 40, 40));
    EXPECT_EQ(after(packets[0], 7), 0);
    EXPECT_EQ(after(packets[0], 64), row.slot_64);
    EXPECT_EQ(after(packets[0], 127), row.slot_127);
    EXPECT_EQ(after(packets[0], 256), 2 * row.sequence);
    EXPECT_EQ(packets[0].slots[256 + 93].laser, 93);
    // The first firing is that long before the stamp.
    const auto stamp_ns = static_cast<std::int64_t>(packets[0].view().le32(1200) % 1'000'000) * us;
    EXPECT_EQ(stamp_ns, (500'000 * us + row.lag) / us * us);
    EXPECT_EQ(packets[0].slots[0].time, setup.start);
  }
}

TEST(VirtualVls128, RandomRestKeepsItsMeanAndTheDeltasThatWereMeasured) {
  const auto packets = simulate_velodyne(setup_of("velodyne_vls128", "strongest", 100));
  double sum = 0;
  std::set<std::int64_t> rests;
  for (std::size_t i = 1; i < packets.size(); ++i) {
    const auto delta = (packets[i].slots[0].time - packets[i - 1].slots[0].time).count();
    ASSERT_GE(delta, 163'700);
    ASSERT_LE(delta, 168'000);
    rests.insert(after(packets[i], 128));
    sum += static_cast<double>(delta);
  }
  EXPECT_NEAR(sum / static_cast<double>(packets.size() - 1), 165'832, 80);
  EXPECT_GT(rests.size(), 300U);
}

TEST(VirtualVls128, DualModeHoldsOneSequenceInEightBlocksAndFourDummies) {
  VelodyneSetup setup = setup_of("velodyne_alpha_prime", "dual", 110);
  setup.divergence_mrad = 3;
  std::size_t differing = 0;
  for (const SimulatedPacket& packet : simulate_velodyne(setup)) {
    ASSERT_THAT(flags(packet), testing::ElementsAre(0xeeff, 0xeeff, 0xddff, 0xddff, 0xccff, 0xccff, 0xbbff,
                                                    0xbbff, 0xffff, 0xffff, 0xffff, 0xffff));
    ASSERT_EQ(azimuths(packet)[8], 0xffff);
    for (std::size_t i = 0; i < 256; ++i) {
      const SlotTruth& slot = packet.slots[i];
      ASSERT_EQ(slot.laser, i / 64 * 32 + i % 32);
      ASSERT_EQ(slot.echo, i / 32 % 2);
      if (slot.echo == 0) continue;
      const SlotTruth& last = packet.slots[i - 32];
      ASSERT_LE(slot.exact, last.exact);
      if (slot.exact != last.exact) ++differing;
    }
    for (std::size_t i = 256; i < 384; ++i) ASSERT_TRUE(std::isnan(packet.slots[i].wire));
  }
  EXPECT_GT(differing, 100U);
}

TEST(VirtualVls128, ConfidenceModeHoldsReturnReturnAndTheWordOfBoth) {
  VelodyneSetup setup = setup_of("velodyne_vls128", "dual_confidence", 5);
  setup.range_max = 9;
  std::size_t missing = 0;
  for (const SimulatedPacket& packet : simulate_velodyne(setup)) {
    ASSERT_THAT(flags(packet), testing::ElementsAre(0xeeff, 0xeeff, 0xeeff, 0xddff, 0xddff, 0xddff, 0xccff,
                                                    0xccff, 0xccff, 0xbbff, 0xbbff, 0xbbff));
    for (std::size_t bank = 0; bank < 4; ++bank) {
      for (std::size_t k = 0; k < 32; ++k) {
        const std::size_t at = 100 * (3 * bank + 2) + 4 + 3 * k;
        const unsigned word = packet.view().le16(at) * 256U + packet.view().u8(at + 2);
        const SlotTruth& first = packet.slots[96 * bank + k];
        const SlotTruth& second = packet.slots[96 * bank + 32 + k];
        ASSERT_EQ(first.laser, 32 * bank + k);
        ASSERT_EQ(word & 0xfffU, confidence_bits(first.exact, first.reflectivity));
        ASSERT_EQ(word >> 12U, confidence_bits(second.exact, second.reflectivity));
        if (word == 0x800800U) ++missing;
        ASSERT_TRUE(std::isnan(packet.slots[96 * bank + 64 + k].wire));
      }
    }
  }
  EXPECT_GT(missing, 0U);
  // 50 %, 7 m away: interference 2, sun 1, confidence 4.
  EXPECT_EQ(confidence_bits(7, 0.5), 2U << 5U | 1U << 3U | 4U);
}

}  // namespace
