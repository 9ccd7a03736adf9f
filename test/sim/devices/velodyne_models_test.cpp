// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "test/sim/devices/velodyne_testing.h"
#include "test/sim/servers/scene_file.h"

namespace {

using namespace lidard;
using namespace lidard::sim;

TEST(VelodyneTables, HoldTheValuesOfTheManuals) {
  struct Sample {
    const char* model;
    std::size_t lasers, laser;
    double elevation, rot, z_mm;
  };
  const Sample samples[] = {
      {"velodyne_vlp16", 16, 13, 13, 0, -9.7},
      {"velodyne_puck_lite", 16, 0, -15, 0, 11.2},
      {"velodyne_puck_hires", 16, 3, 2, 0, -1.8},
      {"velodyne_vlp32a", 32, 28, -1.167, -3.6, 0.864},
      {"velodyne_vlp32b", 32, 29, 15, 1.4, -11.361},
      {"velodyne_vlp32c", 32, 14, 0.667, -4.2, -0.494},
      {"velodyne_hdl32e", 32, 0, -30.67, 0, 17.17},
      {"velodyne_hdl32e", 32, 31, 10.67, 0, -5.45},
      {"velodyne_hdl64e_s1", 64, 38, -24.71, -1, 0},
      {"velodyne_hdl64e_s2", 64, 31, -0.02, 1.7, 0},
      {"velodyne_hdl64e_s21", 64, 29, 4.97, 2.51, 0},
      {"velodyne_hdl64e_s3", 64, 63, -11.91, 1.66, 0},
      {"velodyne_vls128", 128, 36, -25, 0.911, 27.339},
      {"velodyne_alpha_prime", 128, 59, 15, -0.911, -15.710},
  };
  for (const Sample& sample : samples) {
    const VelodyneTable& table = velodyne_table(sample.model);
    ASSERT_EQ(table.lasers.size(), sample.lasers) << sample.model;
    const VelodyneLaser& laser = table.lasers[sample.laser];
    EXPECT_DOUBLE_EQ(laser.elevation_deg, sample.elevation) << sample.model;
    EXPECT_DOUBLE_EQ(laser.rot_correction_deg, sample.rot) << sample.model;
    EXPECT_NEAR(laser.z_offset_mm, sample.z_mm, 0.001) << sample.model;
  }
  EXPECT_THROW(velodyne_table("velodyne_vlp17"), std::invalid_argument);
}

TEST(VelodyneTables, NoTwoLasersShareAnElevationAndTheShiftOfAVls128RepeatsEveryEight) {
  for (const VelodyneTable& table : velodyne_tables()) {
    std::set<double> elevations;
    for (const VelodyneLaser& laser : table.lasers) elevations.insert(laser.elevation_deg);
    EXPECT_EQ(elevations.size(), table.lasers.size()) << table.name;
    for (const VelodyneTiming& timing : table.timings)
      EXPECT_EQ(timing.firing_ns.size(), table.lasers.size()) << table.name;
  }
  const double shifts[] = {-6.354, -4.548, -2.732, -0.911, 0.911, 2.732, 4.548, 6.354};
  for (std::size_t i = 0; i < 128; ++i)
    EXPECT_EQ(velodyne_table("velodyne_vls128").lasers[i].rot_correction_deg, shifts[i % 8]);
}

TEST(VelodyneModels, EveryModelAndModeSendsItsFactoryBytesAtItsRate) {
  struct Row {
    const char* model;
    const char* mode;
    int mode_byte, product;
    double period_us;
  };
  const Row rows[] = {
      {"velodyne_puck_lite", "strongest", 0x37, 0x22, 1327.104},
      {"velodyne_puck_hires", "last", 0x38, 0x24, 1327.104},
      {"velodyne_puck_hires", "dual", 0x39, 0x24, 663.552},
      {"velodyne_vlp32a", "strongest", 0x37, 0x23, 663.552},
      {"velodyne_vlp32b", "dual", 0x39, 0x23, 331.776},
      {"velodyne_vlp32c", "strongest", 0x37, 0x28, 663.552},
      {"velodyne_vlp32c", "dual", 0x39, 0x28, 331.776},
      {"velodyne_hdl32e", "last", 0x38, 0x21, 552.960},
      {"velodyne_hdl32e", "dual", 0x39, 0x21, 276.480},
      {"velodyne_hdl64e_s1", "strongest", 'g', 'C', 384.0},
      {"velodyne_hdl64e_s2", "strongest", 'H', 0, 288.0},
      {"velodyne_hdl64e_s21", "dual", 'H', 0, 144.0},
      {"velodyne_hdl64e_s3", "strongest", 'H', 0, 345.6},
      {"velodyne_hdl64e_s3", "dual", 'H', 0, 172.8},
      {"velodyne_vls128", "last", 0x38, 0xa1, 165.822},
      {"velodyne_alpha_prime", "dual", 0x39, 0xa1, 55.274},
      {"velodyne_vls128", "dual_confidence", 0x3b, 0xa1, 55.274},
  };
  for (const Row& row : rows) {
    SCOPED_TRACE(std::string(row.model) + " " + row.mode);
    VelodyneSetup setup = setup_of(row.model, row.mode);
    if (std::string(row.model).find("128") != std::string::npos ||
        std::string(row.model).find("alpha") != std::string::npos)
      setup.rest_spread_us = 0;
    const auto packets = simulate_velodyne(setup);
    ASSERT_GT(packets.size(), 10U);
    EXPECT_EQ(packets[0].payload.size(), 1206U);
    EXPECT_EQ(packets[0].view().u8(1204), row.mode_byte);
    EXPECT_EQ(packets[0].view().u8(1205), row.product);
    EXPECT_NEAR(static_cast<double>((packets[10].arrival - packets[0].arrival).count()),
                10'000 * row.period_us, 1);
    EXPECT_EQ(packets[0].slots.size(), 384U);
  }
}

TEST(VelodyneModels, EveryAzimuthIsExactOnTheWireByDefault) {
  for (const VelodyneTable& table : velodyne_tables()) {
    VelodyneSetup setup = setup_of(table.name);
    setup.rest_spread_us = 0;
    const auto packets = simulate_velodyne(setup);
    ASSERT_GT(packets.size(), 10U) << table.name;
    for (const SimulatedPacket& packet : packets) {
      for (std::size_t b = 0; b < 12; ++b) {
        const SlotTruth& first = packet.slots[32 * b];
        const double bank_ns = static_cast<double>(table.timings[0].firing_ns[first.laser]);
        const double head =
            first.azimuth / rad_per_deg + table.lasers[first.laser].rot_correction_deg -
            bank_ns / static_cast<double>(table.timings[0].period_ns()) * table.timings[0].turn_deg;
        ASSERT_NEAR(std::remainder(head - packet.view().le16(100 * b + 2) / 100.0, 360), 0, 1e-6)
            << table.name;
      }
    }
  }
}

TEST(VirtualVlp32, PairsFireTogetherAndTheCorrectionIsSubtracted) {
  VelodyneSetup setup = setup_of("velodyne_vlp32c");
  setup.start_azimuth_deg = 100;
  const auto packets = simulate_velodyne(setup);
  EXPECT_THAT(flags(packets[0]), testing::Each(0xeeff));
  EXPECT_THAT(azimuths(packets[0]), testing::ElementsAre(10000, 10020, 10040, 10060, 10080, 10100, 10120,
                                                         10140, 10160, 10180, 10200, 10220));
  // Block 5, lasers 14 and 15: 5 * 55.296 + 7 * 2.304 us; laser 14 looks 4.2 deg further.
  EXPECT_EQ(after(packets[0], 5 * 32 + 14), 292'608);
  EXPECT_EQ(after(packets[0], 5 * 32 + 15), 292'608);
  const double head = 101 + 0.2 * 16.128 / 55.296;
  EXPECT_NEAR(packets[0].slots[5 * 32 + 14].azimuth / rad_per_deg, head + 4.2, 1e-9);
  EXPECT_NEAR(packets[0].slots[5 * 32 + 15].azimuth / rad_per_deg, head - 1.4, 1e-9);
  EXPECT_EQ(packets[0].view().le32(1200), (17U * 60 + 23) * 1'000'000 + 500'000);
  EXPECT_EQ(packets[1].view().le32(1200), (17U * 60 + 23) * 1'000'000 + 500'663);
}

TEST(VirtualVlp32, DistancesAreInFourMillimetresFromWhereTheBeamCrossesTheAxis) {
  const VelodyneTable& table = velodyne_table("velodyne_vlp32c");
  const auto packets = simulate_velodyne(setup_of("velodyne_vlp32c"));
  ASSERT_GT(packets.size(), 25U);
  for (const SimulatedPacket& packet : packets) {
    ASSERT_EQ(packet.slots.size(), 384U);
    for (std::size_t i = 0; i < 384; ++i) {
      const SlotTruth& slot = packet.slots[i];
      ASSERT_NEAR(packet.view().le16(100 * (i / 32) + 4 + 3 * (i % 32)) * 0.004, slot.wire, 1e-9);
      ASSERT_NEAR(slot.wire, slot.exact, 0.002 + 1e-9);
      const double elevation = table.lasers[slot.laser].elevation_deg * rad_per_deg;
      ASSERT_NEAR(slot.xyz.z(), -0.0424 * std::tan(elevation) + slot.exact * std::sin(elevation), 1e-9);
      ASSERT_NEAR(std::remainder(std::atan2(-slot.xyz.y(), slot.xyz.x()) - slot.azimuth, 2 * pi_d), 0, 1e-9);
      ASSERT_LT((wire_point(slot, table) - slot.xyz).norm(), 0.002 + 1e-9);
    }
  }
}

TEST(VirtualVlp32, RoomIsClosedAndDiffersInEveryDirection) {
  std::set<std::int64_t> distances;
  std::size_t slots = 0;
  for (const SimulatedPacket& packet : simulate_velodyne(setup_of("velodyne_vlp32c", "strongest", 95))) {
    for (const SlotTruth& slot : packet.slots) {
      ASSERT_TRUE(slot.exact > 1.5 && slot.exact < 13) << slot.exact;
      distances.insert(std::llround(slot.exact * 1e9));
      ++slots;
    }
  }
  EXPECT_GT(static_cast<double>(distances.size()), 0.98 * static_cast<double>(slots));
}

TEST(VirtualHdl32, LasersFireSinglyAndTheStampIsTheFirstFirings) {
  const auto packets = simulate_velodyne(setup_of("velodyne_hdl32e"));
  EXPECT_THAT(flags(packets[0]), testing::Each(0xeeff));
  EXPECT_EQ(azimuths(packets[0])[11], 176);
  EXPECT_EQ(after(packets[0], 31), 35'712);
  EXPECT_EQ(after(packets[0], 11 * 32 + 31), 542'592);
  EXPECT_EQ(packets[0].view().le32(1200) % 1'000'000, 500'000U);
}

TEST(VirtualHdl32, OldFirmwareStampsTheLastFiringAndHasNoFactoryBytes) {
  VelodyneSetup setup = setup_of("velodyne_hdl32e");
  setup.old_stamp = true;
  const auto packets = simulate_velodyne(setup);
  EXPECT_EQ(packets[0].slots[0].time, setup.start);
  EXPECT_EQ(packets[0].view().le32(1200) % 1'000'000, 500'542U);
  EXPECT_EQ(packets[1].view().le32(1200) % 1'000'000, 501'095U);
  EXPECT_EQ(packets[0].view().le16(1204), 0);
}

TEST(VelodyneSector, PacketOfAVlp32StraddlesTheSilence) {
  VelodyneSetup setup = setup_of("velodyne_vlp32c", "strongest", 270);
  setup.fov = AzimuthSector{270, 91};
  setup.start_azimuth_deg = 80;
  const auto packets = simulate_velodyne(setup);
  std::size_t straddling = 0;
  for (std::size_t p = 0; p < packets.size(); ++p) {
    const auto az = azimuths(packets[p]);
    for (std::size_t b = 1; b < 12; ++b) {
      ASSERT_TRUE(az[b] >= 27000 || az[b] <= 9100);
      const std::int64_t step = after(packets[p], 32 * b, 32 * (b - 1));
      if (az[b] - az[b - 1] == 20 || az[b] - az[b - 1] == 20 - 36000) {
        ASSERT_EQ(step, 55'296);
        continue;
      }
      ++straddling;
      // From 91.00 to 270.00 deg: 895 steps of 0.2 deg, 49.49 ms; the motor and the firings go on.
      ASSERT_EQ(az[b - 1], 9100);
      ASSERT_EQ(az[b], 27000);
      ASSERT_EQ(step, 895 * 55'296);
    }
    const auto last = packets[p].slots.back().time;
    EXPECT_EQ((packets[p].arrival - last).count(), 20'000) << "sent after its last firing";
    const auto begin = (packets[p].slots[0].time - setup.start).count() / us;
    EXPECT_EQ(packets[p].view().le32(1200) % 1'000'000, (500'000 + begin) % 1'000'000)
        << "stamped with its first";
  }
  EXPECT_EQ(straddling, 3U);
}

TEST(VelodyneSector, EveryModelIsSilentOutsideAndKeepsTheRhythm) {
  for (const VelodyneTable& table : velodyne_tables()) {
    SCOPED_TRACE(table.name);
    VelodyneSetup setup = setup_of(table.name, "strongest", 100);
    setup.fov = AzimuthSector{100, 140};
    const auto packets = simulate_velodyne(setup);
    ASSERT_GT(packets.size(), 5U);
    for (const SimulatedPacket& packet : packets) {
      for (const int azimuth : azimuths(packet)) ASSERT_TRUE(azimuth >= 10000 && azimuth <= 14000) << azimuth;
    }
  }
}

TEST(VelodyneSetupErrors, AreToldWithWhatIsExpected) {
  const auto complaint = [](const VelodyneSetup& setup) -> std::string {
    try {
      simulate_velodyne(setup);
    } catch (const SceneError& error) {
      return error.what();
    }
    return "none";
  };
  using testing::HasSubstr;
  EXPECT_THAT(complaint(setup_of("velodyne_vlp16", "dual_confidence")),
              HasSubstr("one of strongest, last, dual"));
  EXPECT_THAT(complaint(setup_of("velodyne_hdl64e_s1", "dual")),
              HasSubstr("expected one of strongest, last"));
  EXPECT_THAT(complaint(setup_of("velodyne_vlp17")), HasSubstr("unknown model 'velodyne_vlp17'"));
  VelodyneSetup setup = setup_of("velodyne_vls128");
  setup.timing = "d";
  EXPECT_THAT(complaint(setup), HasSubstr("unknown timing 'd' of velodyne_vls128; expected one of b, a, c"));
  setup = setup_of("velodyne_vlp16");
  setup.old_stamp = true;
  EXPECT_THAT(complaint(setup), HasSubstr("only velodyne_hdl32e"));
  setup.old_stamp = false;
  setup.fov = AzimuthSector{10, 11};
  EXPECT_THAT(complaint(setup), HasSubstr("at least 3 apart"));
  setup.fov = AzimuthSector{10, 20};
  setup.rpm = 0;
  EXPECT_THAT(complaint(setup), HasSubstr("fov needs a motor that turns"));
  setup.rpm = 600;
  setup.turn_deg = 0.2;
  EXPECT_THAT(complaint(setup), HasSubstr("leave one out"));
}

}  // namespace
