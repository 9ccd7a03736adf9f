// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What neither the shipped captures (Shipped, byte by byte) nor the driver (VelodyneTruth, each return of
// each model and mode against the truth) compare: position packets, and settings that do not fit.
#include "test/sim/devices/velodyne.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "test/sim/servers/test_scene.h"

namespace {

using namespace lidard;
using namespace lidard::sim;
using ::testing::HasSubstr;

TEST(VirtualVlp16, PositionPacketsCarryTheTimeAndASentenceWithItsChecksum) {
  std::size_t telemetry = 0;
  for (const KeptPacket& packet :
       all_packets(room("velodyne_vlp16", "options: {telemetry_hz: 50, pps_locked: true}"))) {
    if (packet.to.port != 8308) continue;
    ++telemetry;
    EXPECT_FALSE(packet.measured);
    ASSERT_EQ(packet.payload.size(), 512U);
    EXPECT_EQ(packet.view().u8(0xca), 2);
    const std::string sentence(packet.view().sub(0xce, 71).text());
    // The checksum is the exclusive or of the characters between $ and *.
    EXPECT_THAT(sentence,
                HasSubstr("$GPRMC,001723,A,0000.0000,N,00000.0000,E,000.0,000.0,010126,000.0,E*75"));
  }
  EXPECT_EQ(telemetry, 5U);
}

TEST(VirtualVelodyne, SettingsThatDoNotFitAreReportedWithWhatIsExpected) {
  const auto complaint = [](const char* model, const std::string& options) -> std::string {
    try {
      room(model, "options: {" + options + "}");
    } catch (const SceneError& error) {
      return error.what();
    }
    return "none";
  };
  EXPECT_THAT(complaint("velodyne_vlp16", "return_mode: dual_confidence"),
              HasSubstr("one of strongest, last, dual"));
  EXPECT_THAT(complaint("velodyne_hdl64e_s1", "return_mode: dual"),
              HasSubstr("expected one of strongest, last"));
  EXPECT_THAT(complaint("velodyne_vls128", "timing: d"),
              HasSubstr("unknown timing 'd' of velodyne_vls128; expected one of b, a, c"));
  EXPECT_THAT(complaint("velodyne_vlp16", "old_stamp: true"), HasSubstr("only velodyne_hdl32e"));
  EXPECT_THAT(complaint("velodyne_vlp16", "fov: {start_deg: 10, end_deg: 11}"),
              HasSubstr("at least 3 apart"));
  EXPECT_THAT(complaint("velodyne_vlp16", "rpm: 0, fov: {start_deg: 10, end_deg: 20}"),
              HasSubstr("fov needs a motor that turns"));
  EXPECT_THAT(complaint("velodyne_vlp16", "rpm: 600, turn_deg: 0.2"), HasSubstr("leave one out"));
}

}  // namespace
