// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/devices/velodyne.h"

#include <gtest/gtest.h>

#include <cmath>

#include "test/sim/devices/velodyne_telemetry.h"
#include "test/sim/servers/test_scene.h"

namespace {

using namespace lidard;
using namespace lidard::sim;

std::vector<KeptPacket> packets(const std::string& keys, const std::string& extra = "") {
  return all_packets(room("velodyne_vlp16", keys, extra));
}

TEST(VirtualVlp16, PacketHasTheBytesOfTheManual) {
  const auto kept = packets("options: {start_azimuth_deg: 90}");
  const ByteView payload = kept.front().view();
  ASSERT_EQ(payload.size(), 1206U);
  for (std::size_t block = 0; block < 12; ++block) {
    EXPECT_EQ(payload.u8(100 * block), 0xff);
    EXPECT_EQ(payload.u8(100 * block + 1), 0xee);
    EXPECT_EQ(payload.le16(100 * block + 2), 9000 + 40 * block);
  }
  EXPECT_EQ(payload.le32(1200), (17U * 60 + 23) * 1000000 + 500000);
  EXPECT_EQ(payload.u8(1204), 0x37);
  EXPECT_EQ(payload.u8(1205), 0x22);
  // Azimuth 90 deg is to the right; laser 0 looks 15 deg down from 11.2 mm above the centre, laser 1 1 deg
  // up.
  EXPECT_EQ(payload.le16(4), std::lround(5 / std::cos(15 * rad_per_deg) / 0.002));
  EXPECT_EQ(payload.le16(7), std::lround(5 / std::cos(1 * rad_per_deg) / 0.002));
  EXPECT_EQ(payload.u8(6), 55) << "reflectivity 50 %";
}

TEST(VirtualVlp16, EveryLaserFiresAtTheTimeOfTheManualAndTurnsOnMeanwhile) {
  const auto kept = packets("options: {start_azimuth_deg: 10}");
  ASSERT_GT(kept.size(), 50U);
  for (const std::size_t p : {std::size_t{0}, std::size_t{50}}) {
    const Measurement& measurement = kept[p].measurement;
    ASSERT_EQ(measurement.slots.size(), 384U);
    for (std::size_t i = 0; i < 384; ++i) {
      const std::size_t block = i / 32;
      const std::size_t k = i % 32;
      const double us = 110.592 * static_cast<double>(block) + 55.296 * static_cast<double>(k / 16) +
                        2.304 * static_cast<double>(k % 16);
      const SlotTruth& slot = measurement.slots[i];
      EXPECT_EQ((slot.time - measurement.begin).count(), std::llround(us * 1000)) << i;
      const double turned = (1327.104 * static_cast<double>(p) + us) * 0.2 / 55.296;
      EXPECT_NEAR(slot.azimuth / rad_per_deg, std::fmod(10 + turned, 360), 1e-9) << i;
      EXPECT_EQ(slot.laser, k % 16);
    }
  }
}

TEST(VirtualVlp16, PacketLeavesAfterItsLastFiringAndTheNextOneFollowsAtTheManualsRate) {
  const auto kept = packets("latency_us: 20");
  ASSERT_GT(kept.size(), 50U);
  EXPECT_EQ((kept[0].time - kept[0].measurement.begin).count(), 1306368 + 20000);
  for (std::size_t i = 1; i < kept.size(); ++i) EXPECT_EQ((kept[i].time - kept[i - 1].time).count(), 1327104);
}

TEST(VirtualVlp16, PointIsWhereTheBeamMeetsTheWallAndTheWireRoundsToTwoMillimetres) {
  const auto kept = packets("options: {}");
  ASSERT_GT(kept.size(), 50U);
  for (const KeptPacket& packet : kept) {
    ASSERT_EQ(packet.measurement.slots.size(), 384U);
    for (std::size_t i = 0; i < packet.measurement.slots.size(); ++i) {
      const SlotTruth& slot = packet.measurement.slots[i];
      const double to_wall = std::max(std::abs(slot.xyz.x()), std::abs(slot.xyz.y()));
      ASSERT_NEAR(to_wall, 5, 1e-9);
      ASSERT_NEAR(std::atan2(-slot.xyz.y(), slot.xyz.x()), std::remainder(slot.azimuth, 2 * pi_d), 1e-9);
      ASSERT_NEAR(slot.wire, slot.exact, 0.001 + 1e-9);
      const std::size_t at = 100 * (i / 32) + 4 + 3 * (i % 32);
      ASSERT_NEAR(packet.view().le16(at) * 0.002, slot.wire, 1e-9);
    }
  }
}

TEST(VirtualVlp16, BeamOriginIsRaisedAsInTheManual) {
  const auto kept = packets("options: {}");
  const SlotTruth& lowest = kept.front().measurement.slots[0];
  EXPECT_NEAR(lowest.xyz.z(), 0.0112 - 5 * std::tan(15 * rad_per_deg), 1e-9);
}

TEST(VirtualVlp16, NothingInRangeGivesCountZero) {
  const auto kept = packets("range_max: 4, options: {}");
  for (std::size_t i = 0; i < 384; ++i) {
    EXPECT_EQ(kept.front().view().le16(100 * (i / 32) + 4 + 3 * (i % 32)), 0);
    EXPECT_EQ(kept.front().measurement.slots[i].exact, no_hit);
    EXPECT_EQ(kept.front().measurement.slots[i].wire, no_hit);
  }
}

TEST(VirtualVlp16, DualModeHoldsLastThenStrongestOfTheSameBeams) {
  const std::string pole = "  - cylinder: {center: [2, 0, 0], radius: 0.1, height: 9, reflectivity: 0.9}\n";
  const auto kept = packets("divergence_mrad: 3, options: {return_mode: dual}", pole);
  EXPECT_EQ((kept[1].time - kept[0].time).count(), 663552);
  std::size_t pairs = 0;
  for (const KeptPacket& packet : kept) {
    EXPECT_EQ(packet.view().u8(1204), 0x39);
    for (std::size_t pair = 0; pair < 6; ++pair) {
      EXPECT_EQ(packet.view().le16(200 * pair + 2), packet.view().le16(200 * pair + 102));
      for (std::size_t k = 0; k < 32; ++k) {
        const SlotTruth& last = packet.measurement.slots[64 * pair + k];
        const SlotTruth& strongest = packet.measurement.slots[64 * pair + 32 + k];
        EXPECT_EQ(last.time, strongest.time);
        EXPECT_EQ(last.echo, 0);
        EXPECT_EQ(strongest.echo, 1);
        if (last.exact == strongest.exact) continue;
        ++pairs;
        EXPECT_GT(last.exact, strongest.exact + 1);
        EXPECT_LT(strongest.exact, 2.2);
      }
    }
  }
  // The pole has two edges that 16 lasers touch; a step of 0.2 deg meets an edge of 3 mrad = 0.17 deg or not.
  EXPECT_GE(pairs, 16U);
  EXPECT_LE(pairs, 64U);
}

TEST(VirtualVlp16, SingleModesChooseAmongTheEchoesOfAnEdge) {
  // The sensor's field is half covered by a near, dark wall whose edge lies straight ahead.
  const std::string wall = "  - wall: {from: [3, 0], to: [3, 5], z: [-9, 9], reflectivity: 0.01}\n";
  const auto strongest = packets("divergence_mrad: 3, options: {return_mode: strongest}", wall);
  const auto last = packets("divergence_mrad: 3, options: {return_mode: last}", wall);
  EXPECT_EQ(last.front().view().u8(1204), 0x38);
  EXPECT_NEAR(strongest.front().measurement.slots[0].exact * std::cos(15 * rad_per_deg), 5, 0.01);
  EXPECT_NEAR(last.front().measurement.slots[0].exact * std::cos(15 * rad_per_deg), 5, 0.01);
  const std::string bright = "  - wall: {from: [3, 0], to: [3, 5], z: [-9, 9], reflectivity: 0.9}\n";
  const auto near = packets("divergence_mrad: 3, options: {return_mode: strongest}", bright);
  EXPECT_NEAR(near.front().measurement.slots[0].exact * std::cos(15 * rad_per_deg), 3, 0.01);
}

TEST(VirtualVlp16, MotorSpeedSetsTheStepOfTheAzimuth) {
  const auto kept = packets("options: {rpm: 1200}");
  // 20 turns per second: 7200 deg/s * 110.592 us = 0.796 deg per block.
  EXPECT_EQ(kept.front().view().le16(1100 + 2), std::lround(11 * 0.7962624 * 100));
}

TEST(VirtualVlp16, DeviceClockWrapsAtTheHourAndHoldsItsOffset) {
  const auto kept = packets("clock_offset: -1043.45, options: {}");  // 17 min 23.5 s - 50 ms
  EXPECT_EQ(kept.front().view().le32(1200), 50000U);
  const auto before = packets("clock_offset: -1043.55, options: {}");
  EXPECT_EQ(before.front().view().le32(1200), 3600000000U - 50000U);
}

TEST(VirtualVlp16, PositionPacketsCarryTheTimeAndASentenceWithItsChecksum) {
  const auto kept = packets("options: {telemetry_hz: 50, pps_locked: true}");
  std::size_t telemetry = 0;
  for (const KeptPacket& packet : kept) {
    if (packet.to.port != 8308) continue;
    ++telemetry;
    EXPECT_FALSE(packet.measured);
    ASSERT_EQ(packet.payload.size(), 512U);
    EXPECT_EQ(packet.view().u8(0xca), 2);
    EXPECT_EQ(packet.view().sub(0xce, 14).text(), "$GPRMC,001723,");
  }
  EXPECT_EQ(telemetry, 5U);
}

TEST(VirtualVlp16, SentenceIsAsAReceiverWritesIt) {
  // 2026-01-01 00:17:23; checksum by hand from the exclusive or of all characters between $ and *.
  const std::string sentence = gprmc({1767226643'000000000}, true);
  EXPECT_EQ(sentence.substr(0, sentence.find('*')),
            "$GPRMC,001723,A,0000.0000,N,00000.0000,E,000.0,000.0,010126,000.0,E");
  unsigned sum = 0;
  for (const char c : sentence.substr(1, sentence.find('*') - 1)) sum ^= static_cast<unsigned char>(c);
  EXPECT_EQ(std::stoul(sentence.substr(sentence.find('*') + 1, 2), nullptr, 16), sum);
  EXPECT_EQ(sentence.substr(sentence.size() - 2), "\r\n");
}

}  // namespace
