// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "drivers/velodyne/calibration.h"
#include "drivers/velodyne/models.h"
#include "drivers/velodyne/packet_stream.h"

namespace lidard::velodyne {
namespace {

const ModelRow& row_of(const char* name) { return *static_cast<const ModelRow*>(find_model(name)->row); }

TEST(VelodyneTable, Vlp16ElevationsAreTheOddDegreesAndRingsAscend) {
  const ModelRow& row = row_of("velodyne_vlp16");
  const auto rings = rings_by_elevation(table_of(row));
  for (std::size_t id = 0; id < row.lasers; ++id) {
    EXPECT_EQ(row.laser[id].elevation_deg, -15 + 2.0 * rings[id]);
    // 63-9243 Rev D, table 9-1: the beams leave a circle of 41.91 mm radius.
    EXPECT_NEAR(row.laser[id].z_offset_mm, -41.91 * std::tan(row.laser[id].elevation_deg * M_PI / 180), 0.06);
  }
}

TEST(VelodyneTable, Vlp16PacketPeriodsAreThoseOfTheManual) {
  const ModelRow& row = row_of("velodyne_vlp16");
  EXPECT_EQ(row.packet_period(row.timings.front(), 1).count(), 1327104);
  EXPECT_EQ(row.packet_period(row.timings.front(), 2).count(), 663552);
  EXPECT_EQ(row.firing_time(row.timings.front(), 15).count(), 34560);
}

TEST(VelodyneTable, HourStampsDifferAcrossTheTopOfTheHour) {
  EXPECT_EQ(hour_difference(100, 3'599'999'900).count(), 200'000);
  EXPECT_EQ(hour_difference(3'599'999'900, 100).count(), -200'000);
  EXPECT_EQ(hour_difference(3'600'001'000, 3'599'999'000).count(), 2'000'000);
  EXPECT_EQ(hour_difference(5, 5).count(), 0);
}

TEST(VelodyneTable, UnknownModelHasNoRow) { EXPECT_EQ(find_model("velodyne_vlp17"), nullptr); }

}  // namespace
}  // namespace lidard::velodyne
