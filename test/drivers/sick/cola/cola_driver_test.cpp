// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>

#include <cmath>

#include "drivers/registry/registry.h"
#include "drivers/sick/cola/cola_models.h"
#include "test/drivers/sick/cola/cola_bench.h"
#include "test/sim/world/units.h"
#include "test/support/allocations.h"

namespace lidard::test {
namespace {

using sim::Cola;
using ::testing::ElementsAre;

TEST(ColaDriver, AnglesAreThoseOfRos) {
  ColaBench bench;
  bench.send_sample();
  ASSERT_EQ(bench.scans.size(), 1U);
  const PlanarScan& scan = bench.scans[0];
  EXPECT_EQ(scan.beams, 541U);
  EXPECT_NEAR(scan.angle_min, -135 * pi_d / 180, 1e-6);
  EXPECT_NEAR(scan.angle_max, 135 * pi_d / 180, 1e-5);
  EXPECT_NEAR(scan.angle_increment, 0.5 * pi_d / 180, 1e-8);
  EXPECT_EQ(scan.frame_id, "laser");
  EXPECT_NEAR(scan.scan_time, 0.02, 1e-9);
  EXPECT_NEAR(scan.time_increment, 0.02 * 0.5 / 360, 1e-9);
}

TEST(ColaDriver, RoundedStepsStandForTheExactOnes) {
  ColaBench bench("sick_tim7xx");
  bench.sample.channels = {{"DIST1", 1, 0, -450000, 3333, true, std::vector<std::uint16_t>(811, 500)}};
  bench.sample.scan_frequency = 1500;
  bench.sample.measurement_frequency = 162;
  bench.send_sample();
  EXPECT_NEAR(bench.scans.at(0).angle_max, 135 * pi_d / 180, 1e-5);
  EXPECT_NEAR(bench.scans[0].time_increment, 1.0 / 15 / 1080, 1e-9);
}

/// Where the row of a model puts the device's zero.
struct Pointing {
  const char* model;
  double ros_deg_of_zero, ros_deg_of_ten;
};
class EveryModel : public ::testing::TestWithParam<Pointing> {};

TEST_P(EveryModel, ShiftsAndMirrorsAsItsRowSays) {
  ColaBench bench(GetParam().model);
  bench.sample.channels = {
      {"DIST1", 1, 0, 0, 10000, true, {1000, 1000, 1000, 1000, 1000, 1000, 1000, 1000, 1000, 1000, 1000}}};
  bench.send_sample();
  ASSERT_EQ(bench.scans.size(), 1U);
  EXPECT_NEAR(bench.scans[0].angle_min, GetParam().ros_deg_of_zero * pi_d / 180, 1e-6);
  EXPECT_NEAR(bench.scans[0].angle_max, GetParam().ros_deg_of_ten * pi_d / 180, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(
    Cola, EveryModel,
    ::testing::Values(Pointing{"sick_lms1xx", -90, -80}, Pointing{"sick_lms5xx", -90, -80},
                      Pointing{"sick_lms1000", -90, -80}, Pointing{"sick_lms4000", -90, -80},
                      Pointing{"sick_tim240", 0, 10}, Pointing{"sick_tim4xx", -90, -80},
                      Pointing{"sick_tim5xx", -90, -80}, Pointing{"sick_tim7xx", -90, -80},
                      Pointing{"sick_tim7xxs", -90, -80}, Pointing{"sick_lrs36x0", 180, 170},
                      Pointing{"sick_lrs36x1", -180, -170}, Pointing{"sick_nav2xx", 0, 10},
                      Pointing{"sick_nav31x", 180, 170}, Pointing{"sick_oem15xx", 180, 170}),
    [](const auto& each) { return std::string(each.param.model); });

// A legal setting: LMDscandatacfg 02 00.
TEST(ColaDriver, ALaterEchoAloneIsDecodedAndProvesNoFreeSpace) {
  for (const char* name : {"DIST2", "DIST5"}) {
    ColaBench bench("sick_lms5xx");
    bench.sample.channels = {channel(name, {2000, 0, 3000}), channel("RSSI1", {1, 2, 3}),
                             channel(name[4] == '2' ? "RSSI2" : "RSSI5", {7, 8, 9})};
    EXPECT_EQ(bench.send_sample(), Reject::none);
    const PlanarScan& scan = bench.scans.at(0);
    EXPECT_FLOAT_EQ(scan.ranges[0], 2);
    EXPECT_TRUE(std::isnan(scan.ranges[1])) << "the first echo may be near";
    EXPECT_FLOAT_EQ(scan.intensities[2], 9);
    ASSERT_EQ(scan.free_from.size(), 3U);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(scan.free_from[i], scan.range_max);
    EXPECT_TRUE(bench.has_warning(name));
    bench.sample.channels = {channel("DIST1", {2000, 0, 3000})};
    bench.send_next();
    EXPECT_TRUE(std::isinf(bench.scans.at(1).ranges[1]));
    EXPECT_TRUE(bench.scans[1].free_from.empty());
    EXPECT_FALSE(bench.has_warning(name));
  }
}

TEST(ColaDriver, EchoesWithAGapBetweenThemAllCome) {
  DriverConfig config;
  config.publish_multiecho = true;
  ColaBench bench("sick_lms5xx", config);
  bench.sample.channels = {channel("DIST1", {2000, 0}), channel("DIST3", {4000, 0})};
  bench.send_sample();
  const PlanarScan& scan = bench.scans.at(0);
  ASSERT_EQ(scan.echoes, 2U);
  EXPECT_FLOAT_EQ(scan.ranges[scan.index(0, 1)], 4);
  EXPECT_TRUE(scan.free_from.empty());
}

// uos/sick_tim, sick_tim310 parser: two more words before DIST1, none before RSSI1.
TEST(ColaDriver, TheEarlyLayoutOfATim310IsRead) {
  ColaBench bench("sick_tim5xx");
  const std::string text =
      "\2sSN LMDscandata 1 1 B96518 0 0 99 9A 13C8E59 13C9CBE 0 0 8 0 0 5DC 36 0 1 0 0 DIST1 3F800000 "
      "00000000 "
      "FFF92230 2710 3 7D0 7DC 7E8 RSSI1 3F800000 00000000 FFF92230 2710 3 1 2 3 0 0 1 B not defined 0 0 0 "
      "0\3";
  EXPECT_EQ(bench.send({text.begin(), text.end()}), Reject::none);
  const PlanarScan& scan = bench.scans.at(0);
  ASSERT_EQ(scan.beams, 3U);
  EXPECT_FLOAT_EQ(scan.ranges[2], 2.024F);
  EXPECT_FLOAT_EQ(scan.intensities.at(2), 3);
  EXPECT_NEAR(scan.angle_min, -135 * pi_d / 180, 1e-6);
}

TEST(ColaDriver, EveryModelOfTheTableHasAPointingTest) {
  std::size_t planar = 0;
  for (const Model& model : models()) {
    if (model.protocol == "CoLa A/B" && model.kind == FrameKind::scan) ++planar;
  }
  EXPECT_EQ(planar, 14U);
}

TEST(ColaDriver, CodesAreNoDistances) {
  ColaBench bench;
  std::vector<std::uint16_t> raw;
  for (std::uint16_t code = 0; code < 18; ++code) raw.push_back(code);
  raw.insert(raw.end(), {50, 49, 50000, 50001, 65535});
  bench.sample.channels = {channel("DIST1", raw)};
  bench.send_sample();
  const PlanarScan& scan = bench.scans.at(0);
  EXPECT_EQ(scan.statuses[0], BeamStatus::none);
  EXPECT_EQ(scan.ranges[0], infinite);
  for (std::size_t code = 1; code < 16; ++code) EXPECT_TRUE(std::isnan(scan.ranges[code])) << code;
  EXPECT_EQ(scan.ranges[16], -infinite) << "0.016 m is nearer than range_min";
  EXPECT_FLOAT_EQ(scan.ranges[18], 0.05F);
  EXPECT_EQ(scan.ranges[19], -infinite);
  EXPECT_FLOAT_EQ(scan.ranges[20], 50);
  EXPECT_EQ(scan.ranges[21], infinite);
  EXPECT_EQ(scan.ranges[22], infinite);
}

// SICK 8023202 p. 56: 0 is also the distance of what is too near, too dark or removed by a filter.
TEST(ColaDriver, AnLms4000DoesNotSayThatNothingIsThere) {
  ColaBench bench("sick_lms4000");
  bench.sample.channels = {channel("DIST1", {0, 1, 700, 5000})};
  bench.send_sample();
  const PlanarScan& scan = bench.scans.at(0);
  EXPECT_TRUE(std::isnan(scan.ranges[0]));
  EXPECT_TRUE(std::isnan(scan.ranges[1]));
  EXPECT_FLOAT_EQ(scan.ranges[2], 0.7F);
  EXPECT_EQ(scan.ranges[3], infinite) << "beyond its range";
}

// sick_scan_xd, README, interlaced modes: the begin moves by a part of the step from scan to scan.
TEST(ColaDriver, AnInterlacedScanIsNoChangeOfSettings) {
  ColaBench bench("sick_lms1000");
  for (const std::int32_t start : {-480000, -478125, -476250, -474375, -480000}) {
    bench.sample.channels = {{"DIST1", 1, 0, start, 7500, true, {1000, 1000, 1000}}};
    bench.send_sample();
  }
  ASSERT_EQ(bench.scans.size(), 5U);
  EXPECT_NEAR(bench.scans[1].angle_min - bench.scans[0].angle_min, 0.1875 * pi_d / 180, 1e-6);
  EXPECT_TRUE(bench.driver->info().warnings.empty());
  bench.sample.channels = {{"DIST1", 1, 0, -400000, 7500, true, {1000, 1000, 1000}}};
  bench.send_sample();
  EXPECT_FALSE(bench.driver->info().warnings.empty());
}

TEST(ColaDriver, ScaleAndOffsetApplyToDistancesAndNotToCodes) {
  for (const Cola dialect : {Cola::binary, Cola::text}) {
    ColaBench bench("sick_lms5xx");
    bench.dialect = dialect;
    bench.sample.channels = {{"DIST1", 2, 100, -50000, 5000, true, {0, 1, 15, 16, 1000}}};
    bench.send_sample();
    const PlanarScan& scan = bench.scans.at(0);
    EXPECT_EQ(scan.ranges[0], infinite);
    EXPECT_TRUE(std::isnan(scan.ranges[2]));
    EXPECT_FLOAT_EQ(scan.ranges[3], 0.132F);
    EXPECT_FLOAT_EQ(scan.ranges[4], 2.1F);
  }
}

TEST(ColaDriver, IntensitiesComeWith8And16Bits) {
  ColaBench bench;
  bench.sample.channels = {channel("DIST1", {100, 200}), channel("RSSI1", {254, 3}, false)};
  bench.send_sample();
  EXPECT_THAT(bench.scans.at(0).intensities, ElementsAre(254.0F, 3.0F));
  bench.sample.channels[1] = channel("RSSI1", {65535, 300});
  bench.send_sample();
  EXPECT_THAT(bench.scans.at(1).intensities, ElementsAre(65535.0F, 300.0F));
  DriverConfig without;
  without.publish_intensity = false;
  ColaBench plain("sick_lms1xx", without);
  plain.sample.channels = bench.sample.channels;
  plain.send_sample();
  EXPECT_TRUE(plain.scans.at(0).intensities.empty());
}

TEST(ColaDriver, EchoesComeWhenAskedFor) {
  DriverConfig config;
  config.publish_multiecho = true;
  ColaBench bench("sick_lms5xx", config);
  bench.sample.channels = {channel("DIST1", {100, 200}), channel("DIST2", {0, 400}),
                           channel("RSSI1", {1, 2}, false), channel("RSSI2", {0, 4}, false)};
  bench.send_sample();
  const PlanarScan& scan = bench.scans.at(0);
  EXPECT_EQ(scan.echoes, 2U);
  EXPECT_THAT(scan.ranges, ElementsAre(0.1F, 0.2F, infinite, 0.4F));
  EXPECT_THAT(scan.intensities, ElementsAre(1, 2, 0, 4));
  ColaBench first("sick_lms5xx");
  first.sample = bench.sample;
  first.send_sample();
  EXPECT_EQ(first.scans.at(0).echoes, 1U);
}

TEST(ColaDriver, SaysWhenTheConfiguredAnglesLeaveNothing) {
  DriverConfig config;
  config.angle_min = 3;
  config.angle_max = 3.1;
  ColaBench none("sick_lms5xx", config);
  none.send_sample();
  EXPECT_TRUE(none.scans.empty());
  EXPECT_TRUE(none.has_warning("no beam lies between angle_min and angle_max"));
}

TEST(ColaDriver, LostTelegramsAreCounted) {
  ColaBench bench;
  for (int i = 0; i < 5; ++i) bench.send_next();
  const auto skip = [&](std::uint16_t n) {
    bench.sample.telegram_counter = static_cast<std::uint16_t>(bench.sample.telegram_counter + n);
    bench.sample.start_us += n * 20'000U;
    bench.sample.transmit_us += n * 20'000U;
    bench.now = bench.now + std::chrono::milliseconds(20) * n;
  };
  skip(3);
  bench.send_next();
  EXPECT_EQ(bench.counters().lost_packets, 3U);
  bench.sample.telegram_counter = 0xfffe;
  bench.send_next();  // no time for so many: another count
  EXPECT_EQ(bench.counters().lost_packets, 3U);
  for (int i = 0; i < 5; ++i) bench.send_next();
  EXPECT_EQ(bench.counters().lost_packets, 3U) << "the counter wrapped";
}

TEST(ColaDriver, WhereOnlyScansAreCountedTheirGapsAreLosses) {
  ColaBench bench;
  for (int i = 0; i < 100; ++i) {
    bench.sample.telegram_counter = 0xffff;  // 0 is sent
    bench.send_next();
  }
  EXPECT_EQ(bench.counters().lost_packets, 0U);
}

TEST(ColaDriver, EveryThirdScanIsNoLoss) {
  ColaBench bench;
  for (int i = 0; i < 20; ++i) {
    bench.sample.scan_counter = static_cast<std::uint16_t>(bench.sample.scan_counter + 2);
    bench.send_next();
  }
  EXPECT_EQ(bench.counters().lost_packets, 0U);
}

TEST(ColaDriver, ForeignTelegramsAreSetAside) {
  ColaBench bench;
  bench.send_next();
  bench.sample.command = "sSN LMDscandatamon";
  bench.send_next();
  bench.send(sim::ColaWords(Cola::text, "sSN LMDradardata").number(1, 2).bytes());
  bench.send(sim::ColaWords(Cola::binary, "sRA ODoprh").number(7, 4).bytes());
  EXPECT_EQ(bench.scans.size(), 1U);
  EXPECT_EQ(bench.counters().packets, 1U);
  EXPECT_EQ(bench.counters().other_packets, 3U);
  EXPECT_EQ(bench.counters().rejected_total(), 0U);
}

TEST(ColaDriver, AChangedGeometryIsAWarningAndTheScansGoOn) {
  ColaBench bench;
  bench.send_next();
  bench.sample.channels[0].values.resize(271);
  bench.send_next();
  EXPECT_EQ(bench.scans.back().beams, 271U);
  EXPECT_TRUE(bench.has_warning("the scanner changed from 541 beams"));
}

TEST(ColaDriver, ATelegramWithoutDistancesIsRefusedWithAReason) {
  ColaBench bench;
  bench.sample.channels[0].name = "RSSI1";
  EXPECT_EQ(bench.send_next(), Reject::field);
  EXPECT_TRUE(bench.has_warning("without distances"));
  bench.sample.channels[0].name = "DIST1";
  bench.send_next();
  EXPECT_FALSE(bench.has_warning("without distances"));
  EXPECT_EQ(bench.scans.size(), 1U);
}

}  // namespace
}  // namespace lidard::test
