// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "test/sim/devices/velodyne_testing.h"

namespace {

using namespace lidard;
using namespace lidard::sim;

TEST(VirtualHdl64, BlocksAlternateAndBothFireTogether) {
  for (const char* model : {"velodyne_hdl64e_s2", "velodyne_hdl64e_s21", "velodyne_hdl64e_s3"}) {
    const auto packets = simulate_velodyne(setup_of(model));
    EXPECT_THAT(flags(packets[0]), testing::ElementsAre(0xeeff, 0xddff, 0xeeff, 0xddff, 0xeeff, 0xddff,
                                                        0xeeff, 0xddff, 0xeeff, 0xddff, 0xeeff, 0xddff));
    for (std::size_t i = 0; i < 384; ++i) {
      EXPECT_EQ(packets[0].slots[i].laser, i % 64);
      if (i % 64 < 32) {
        EXPECT_EQ(packets[0].slots[i].time, packets[0].slots[i + 32].time);
      }
    }
    const auto az = azimuths(packets[0]);
    for (std::size_t b = 0; b < 12; b += 2) EXPECT_EQ(az[b], az[b + 1]);
    for (std::size_t b = 2; b < 12; b += 2) EXPECT_EQ(az[b] - az[b - 2], az[2]) << model;
  }
}

TEST(VirtualHdl64, ColumnsHaveTheTimesOfTheirGeneration) {
  const auto s2 = simulate_velodyne(setup_of("velodyne_hdl64e_s2"));
  EXPECT_EQ(azimuths(s2[0])[10], 85);
  EXPECT_EQ(after(s2[0], 5 * 64 + 63), 5 * 48'000 + 7 * 6'000 + 3'660);
  EXPECT_EQ(after(s2[0], 2), 2'460);
  const auto s3 = simulate_velodyne(setup_of("velodyne_hdl64e_s3"));
  EXPECT_EQ(azimuths(s3[0])[10], 100);
  EXPECT_EQ(after(s3[0], 5 * 64 + 29), 5 * 57'600 + 7 * 7'200 + 1'300);
  VelodyneSetup fast = setup_of("velodyne_hdl64e_s3");
  fast.timing = "48";
  EXPECT_EQ(after(simulate_velodyne(fast)[0], 64), 48'000);
}

// What the packets of atwallshort.pcap (chalmers-revere/opendlv.core) have.
TEST(VirtualHdl64, FirstGenerationSendsLowerLasersOnceForThreeTimesTheUpperOnes) {
  VelodyneSetup setup = setup_of("velodyne_hdl64e_s1");
  setup.turn_deg = 0.1138;  // 593 rpm
  const auto packets = simulate_velodyne(setup);
  for (std::size_t p : {0U, 1U, 7U}) {
    EXPECT_THAT(flags(packets[p]), testing::ElementsAre(0xddff, 0xeeff, 0xeeff, 0xeeff, 0xddff, 0xeeff,
                                                        0xeeff, 0xeeff, 0xddff, 0xeeff, 0xeeff, 0xeeff));
    for (std::size_t i = 0; i < 384; ++i)
      EXPECT_EQ(packets[p].slots[i].laser, i % 32 + (i / 32 % 4 == 0 ? 32 : 0));
    EXPECT_EQ(after(packets[p], 5 * 32 + 7), 5 * 32'000 + 7'000);
    const auto* tail = packets[p].payload.data() + 1200;
    EXPECT_EQ(std::string(tail, tail + 6), p % 2 == 0 ? "Q DegC" : "\"\x0cv25c");
  }
  EXPECT_EQ((packets[1].slots[0].time - packets[0].slots[0].time).count(), 384'000);
  int single = 0, twice = 0, last = 0;
  for (std::size_t p = 0; p < packets.size(); ++p) {
    for (const int azimuth : azimuths(packets[p])) {
      const int step = azimuth - last;
      last = azimuth;
      single += step == 9 ? 1 : 0;
      twice += step == 18 ? 1 : 0;
    }
  }
  EXPECT_EQ(static_cast<std::size_t>(single + twice), 12 * packets.size() - 1) << "steps of the encoder";
  EXPECT_NEAR(static_cast<double>(twice) / single, 970.0 / 2701, 0.02) << "as recorded at that speed";
}

TEST(VirtualHdl64, DualModeHoldsThreeColumnsTwiceEach) {
  VelodyneSetup setup = setup_of("velodyne_hdl64e_s3", "dual", 120);
  setup.divergence_mrad = 3;
  std::size_t differing = 0;
  for (const SimulatedPacket& packet : simulate_velodyne(setup)) {
    const auto az = azimuths(packet);
    for (std::size_t b = 0; b < 12; ++b) ASSERT_EQ(az[b], az[b / 4 * 4]);
    for (std::size_t i = 0; i < 384; ++i) {
      const SlotTruth& slot = packet.slots[i];
      ASSERT_EQ(slot.echo, i / 64 % 2);
      if (slot.echo == 1) continue;
      const SlotTruth& last = packet.slots[i + 64];
      ASSERT_EQ(slot.time, last.time);
      if (slot.exact == last.exact) continue;
      ++differing;
      ASSERT_GT(last.exact, slot.exact);
    }
  }
  EXPECT_GT(differing, 100U);
}

TEST(VirtualHdl64, StatusBytesTellTimeAndTheWholeCalibration) {
  VelodyneSetup setup = setup_of("velodyne_hdl64e_s3", "strongest", 1500);
  setup.telemetry_hz = 0;
  const auto packets = simulate_velodyne(setup);
  ASSERT_GE(packets.size(), 4160U);
  const auto type = [&](std::size_t i) { return packets[i].view().u8(1204); };
  const auto value = [&](std::size_t i) { return packets[i].view().u8(1205); };
  std::string types;
  for (std::size_t i = 0; i < 16; ++i) types += static_cast<char>(type(i));
  EXPECT_EQ(types, "HMSDNYGTV1234567");
  const int start[] = {0, 17, 23, 1, 1, 26, 0, 42, 0xe3};
  for (std::size_t i = 0; i < 9; ++i) EXPECT_EQ(value(i), start[i]) << i;
  std::vector<std::uint8_t> calibration;
  for (std::size_t i = 0; i < 4160; ++i)
    if (i % 16 >= 9) calibration.push_back(value(i));
  ASSERT_EQ(calibration.size(), 1820U);
  EXPECT_EQ(std::string(calibration.begin(), calibration.begin() + 5), "UNIT#");
  const ByteView record(calibration.data() + 7 + 28 * 63, 28);
  EXPECT_EQ(record.u8(0), 63);
  EXPECT_EQ(static_cast<std::int16_t>(record.le16(1)), -1191);
  EXPECT_EQ(static_cast<std::int16_t>(record.le16(3)), 166);
  EXPECT_EQ(type(4 * 16 + 9), 'W') << "in every fourth cycle";
  EXPECT_EQ(type(3 * 16 + 9), '1');
  EXPECT_EQ(type(257 * 16 + 9), 0xfe) << "revolutions, low byte";
  EXPECT_EQ(calibration[1820 - 28 + 7] + 256 * calibration[1820 - 28 + 8], 579) << "0.2 deg per 57.6 us";
}

TEST(VirtualHdl64, SecondGenerationSendsTheLengthWhereTheThirdSendsAChecksum) {
  VelodyneSetup setup = setup_of("velodyne_hdl64e_s21", "last", 1250);
  const auto packets = simulate_velodyne(setup);
  ASSERT_GE(packets.size(), 4160U);
  EXPECT_EQ(packets[4158].view().u8(1205) + 256 * packets[4159].view().u8(1205), 1820);
  EXPECT_EQ(packets[259 * 16 + 9 + 2].view().u8(1204), 0xf9);
  EXPECT_EQ(packets[259 * 16 + 9 + 2].view().u8(1205), 1) << "last return";
  for (const SimulatedPacket& packet : packets) ASSERT_NE(packet.view().u8(1204), 'W');
}

}  // namespace
