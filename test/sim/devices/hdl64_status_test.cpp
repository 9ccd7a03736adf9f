// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/devices/hdl64_status.h"

#include <gtest/gtest.h>

#include "drivers/velodyne/hdl64_status.h"
#include "test/sim/world/motion.h"

namespace {

using namespace lidard;

constexpr Stamp now{1'767'226'643'500'000'000};  // 2026-01-01T00:17:23.5Z

/// Sends so many packets' status bytes to the driver's collector.
void send(const sim::Hdl64Status& device, std::size_t first, std::size_t count,
          velodyne::Hdl64Status& collector) {
  for (std::size_t i = first; i < first + count; ++i) {
    const auto bytes = device.at(i, now);
    collector.add(bytes[0], bytes[1]);
  }
}

void expect_lasers(const velodyne::Hdl64Status& collector, const sim::VelodyneLasers& lasers) {
  ASSERT_NE(collector.calibration(), nullptr);
  ASSERT_EQ(collector.calibration()->lasers.size(), 64U);
  for (std::size_t i = 0; i < 64; ++i) {
    const LaserCalibration& laser = collector.calibration()->lasers[i];
    EXPECT_NEAR(laser.vert_correction / sim::rad_per_deg, lasers[i].elevation_deg, 1e-9) << i;
    EXPECT_NEAR(laser.rot_correction / sim::rad_per_deg, lasers[i].rot_correction_deg, 1e-9) << i;
    EXPECT_EQ(laser.dist_correction, 0) << i;
  }
}

TEST(VirtualHdl64Status, DriverReadsTheCalibrationOfAnS3ThatItsChecksumConfirms) {
  const sim::VelodyneTable& table = sim::velodyne_table("velodyne_hdl64e_s3");
  sim::Hdl64State state;
  state.s3 = true;
  state.synchronised = true;
  state.dual = true;
  const sim::Hdl64Status device(table.lasers, state);
  velodyne::Hdl64Status collector;
  // From somewhere in the middle: to the next begin, one round, and the token of the one after it.
  send(device, 1000, 2 * 4160 - 1000 + 16, collector);
  expect_lasers(collector, table.lasers);
  EXPECT_TRUE(collector.info().is_s3);
  EXPECT_EQ(collector.info().gps, 'A');
  EXPECT_EQ(collector.info().temperature, 42);
  EXPECT_EQ(collector.resynchronisations(), 0U);
  ASSERT_TRUE(collector.info().time.has_value());
  EXPECT_EQ(collector.info().time->minute, 17);
  EXPECT_EQ(collector.info().time->year, 2026);
  ASSERT_TRUE(collector.info().settings.has_value());
  EXPECT_EQ(collector.info().settings->rpm, 600);
  EXPECT_EQ(collector.info().settings->return_mode, 2);
}

TEST(VirtualHdl64Status, DriverReadsTheCalibrationOfAnS2AfterThreeEqualRounds) {
  const sim::VelodyneTable& table = sim::velodyne_table("velodyne_hdl64e_s21");
  const sim::Hdl64Status device(table.lasers, {});
  velodyne::Hdl64Status collector;
  send(device, 0, 2 * 4160 + 16, collector);
  EXPECT_EQ(collector.calibration(), nullptr);
  send(device, 2 * 4160 + 16, 4160, collector);
  expect_lasers(collector, table.lasers);
  EXPECT_FALSE(collector.info().is_s3);
}

}  // namespace
