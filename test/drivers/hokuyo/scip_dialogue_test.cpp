// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <regex>

#include "test/drivers/hokuyo/scip_bench.h"

namespace lidard::test {
namespace {

using namespace std::chrono_literals;
using sim::ScipDeviceOptions;

DriverConfig without_comparison() {
  DriverConfig config;
  config.requests.calibrate_time = false;
  return config;
}

ScipDeviceOptions rich() {
  ScipDeviceOptions options;
  options.product = "UTM-30LX-EW";
  options.range_min_mm = 23, options.range_max_mm = 60000;
  options.knows_echoes = true;
  return options;
}

TEST(ScipDialogue, WritesExactlyWhatAStreamNeeds) {
  ScipBench bench({}, without_comparison());
  bench.run(3s);
  EXPECT_EQ(bench.written, "QT\nVV\nPP\nII\nME0000108001000\n");
  EXPECT_NEAR(static_cast<double>(bench.scans.size()), 119, 2);
  EXPECT_EQ(bench.driver->counters().lost_packets, 0U);
  EXPECT_EQ(bench.driver->counters().rejected_total(), 0U);
  EXPECT_TRUE(bench.driver->info().warnings.empty());
}

TEST(ScipDialogue, ComparesTheClocksOnceBeforeTheStream) {
  ScipBench bench;
  bench.run(3s);
  EXPECT_TRUE(std::regex_match(bench.written,
                               std::regex("QT\nVV\nPP\nII\nTM0\n(TM1\n){10,60}TM2\nME0000108001000\n")))
      << bench.written;
  EXPECT_GT(bench.scans.size(), 115U);
}

TEST(ScipDialogue, TellsWhoIsThere) {
  ScipBench bench;
  bench.run(1s);
  EXPECT_EQ(bench.driver->info().serial, "H1234567");
  EXPECT_EQ(bench.detail("Vendor Name"), "Hokuyo Automatic Co., Ltd.");
  EXPECT_EQ(bench.detail("Product Name"), "UST-10LX");
  EXPECT_EQ(bench.detail("Firmware Version"), "2.23.0000 (2016-10-20)");
  EXPECT_EQ(bench.detail("Protocol Version"), "SCIP 2.2");
  EXPECT_EQ(bench.detail("Device Status"), "sensor is working normally");
}

TEST(ScipDialogue, AsksForWhatTheConfigurationWants) {
  DriverConfig config = without_comparison();
  config.publish_intensity = false;
  config.requests.skip = 3;
  config.requests.cluster = 2;
  config.angle_min = -90 * rad_per_deg;
  config.angle_max = 90 * rad_per_deg;
  ScipBench bench({}, config);
  bench.run(2s);
  EXPECT_EQ(bench.written, "QT\nVV\nPP\nII\nMD0180090002300\n");
  ASSERT_GT(bench.scans.size(), 15U);
  EXPECT_EQ(bench.scans[0].beams, 360U) << "a group points to its middle, the last one beyond 90 deg";
  EXPECT_NEAR(bench.scans[0].scan_time, 0.1, 1e-6);
  EXPECT_EQ(bench.driver->counters().lost_packets, 0U);
}

TEST(ScipDialogue, AsksForAllStepsOfASectorThroughStraightBehindAndHidesTheRest) {
  DriverConfig config = without_comparison();
  config.publish_intensity = false;
  config.angle_min = 90 * rad_per_deg;
  config.angle_max = 270 * rad_per_deg;
  ScipBench bench({}, config);
  bench.run(1s);
  EXPECT_EQ(bench.written, "QT\nVV\nPP\nII\nMD0000108001000\n");
  ASSERT_FALSE(bench.scans.empty());
  const PlanarScan& scan = bench.scans[0];
  ASSERT_EQ(scan.beams, 1081U);
  for (std::size_t beam = 181; beam < 900; ++beam)
    EXPECT_EQ(scan.statuses[beam], BeamStatus::invalid) << beam;
  EXPECT_NE(scan.statuses[180], BeamStatus::invalid);
  EXPECT_NE(scan.statuses[900], BeamStatus::invalid);
}

TEST(ScipDialogue, AsksForEchoesWhereTheyAreWanted) {
  DriverConfig config = without_comparison();
  config.publish_multiecho = true;
  ScipBench bench(rich(), config, "hokuyo_utm_30lx_ew");
  bench.run(1s);
  EXPECT_EQ(bench.written, "QT\nVV\nPP\nII\nNE0000108001000\n");
  ASSERT_FALSE(bench.scans.empty());
  EXPECT_EQ(bench.scans[0].echoes, 3U);
}

TEST(ScipDialogue, GoesWithoutWhatTheSensorDoesNotKnowAndSaysSo) {
  DriverConfig config = without_comparison();
  config.publish_multiecho = true;
  ScipDeviceOptions options;
  options.knows_intensities = false;
  ScipBench bench(options, config, "hokuyo_scip");
  bench.run(1s);
  EXPECT_EQ(bench.written, "QT\nVV\nPP\nII\nNE0000108001000\nME0000108001000\nMD0000108001000\n");
  EXPECT_GT(bench.scans.size(), 30U);
  EXPECT_TRUE(bench.has_warning("several echoes"));
  EXPECT_TRUE(bench.has_warning("intensities"));
  EXPECT_EQ(bench.scans[0].echoes, 3U) << "the number of echoes is that of the session";
}

TEST(ScipDialogue, UsesLongStampsWhereTheFirmwareHasThem) {
  ScipDeviceOptions options;
  options.firmware = "4.1.0";
  options.knows_percent = true;
  ScipBench bench(options, without_comparison());
  bench.run(1s);
  EXPECT_EQ(bench.written, "QT\nVV\nPP\nII\n%ME0000108001000\n");
  EXPECT_GT(bench.scans.size(), 30U);
}

TEST(ScipDialogue, FallsBackWhereTheFirmwareOnlySeemsToHaveThem) {
  ScipDeviceOptions options;
  options.firmware = "4.1.0";
  ScipBench bench(options);
  bench.run(1s);
  EXPECT_NE(bench.written.find("%TM1\nTM1\n"), std::string::npos);
  EXPECT_NE(bench.written.find("\nME0000108001000\n"), std::string::npos);
  EXPECT_GT(bench.scans.size(), 30U);
  EXPECT_TRUE(bench.driver->info().warnings.empty());
}

// seqsense/urg_stamped src/urg_sim/urg_sim.cpp, handleMX and sendScan: %ME is acknowledged with its mark, the
// scans follow under ME with stamps of 11 characters.
TEST(ScipDialogue, AnEchoWithoutTheMarkStillHasLongStamps) {
  ScipDeviceOptions options;
  options.firmware = "4.1.0b-A";
  options.knows_percent = options.bare_echo = true;
  ScipBench bench(options);
  bench.run(2s);
  EXPECT_NE(bench.written.find("\n%ME0000108001000\n"), std::string::npos);
  EXPECT_GT(bench.scans.size(), 70U);
  EXPECT_EQ(bench.driver->counters().rejected_total(), 0U);
  EXPECT_TRUE(bench.driver->info().warnings.empty());
}

TEST(ScipDialogue, WhenNothingFitsTheSensorIsAskedAgainAndForLess) {
  ScipDeviceOptions options;
  options.firmware = "4.1.0";
  options.knows_percent = true;
  options.long_stamp = 7;
  ScipBench bench(options, without_comparison());
  bench.run(3s);
  EXPECT_EQ(bench.written, "QT\nVV\nPP\nII\n%ME0000108001000\nQT\nVV\nPP\nII\nME0000108001000\n");
  EXPECT_GT(bench.scans.size(), 50U);
  EXPECT_EQ(bench.reconnects, 0);
  EXPECT_GE(bench.driver->counters().rejected_total(), 20U);
  EXPECT_TRUE(bench.driver->info().warnings.empty()) << "it works, and the counters tell what was lost";
}

TEST(ScipDialogue, WhenNothingHelpsTheUserIsTold) {
  ScipDeviceOptions options;
  options.values_missing = 1;
  ScipBench bench(options, without_comparison());
  bench.run(5s);
  EXPECT_TRUE(bench.scans.empty());
  EXPECT_TRUE(bench.has_warning("no answer of the stream fits what was asked for (size)"));
  bench.sensor.options().values_missing = 0;
  bench.run(2s);
  EXPECT_FALSE(bench.scans.empty());
  EXPECT_TRUE(bench.driver->info().warnings.empty());
}

TEST(ScipDialogue, LeavesATimeModeThatAFormerClientLeftOn) {
  ScipBench bench({}, without_comparison());
  bench.sensor.options().refusals["QT"] = "0E";
  bench.run(1s);
  EXPECT_EQ(bench.written, "QT\nTM2\nVV\nPP\nII\nME0000108001000\n");
  EXPECT_GT(bench.scans.size(), 30U);
}

TEST(ScipDialogue, ARefusedClockComparisonCostsNothingElse) {
  ScipBench bench;
  bench.sensor.options().refusals["TM0"] = "10";
  bench.run(1s);
  EXPECT_EQ(bench.written, "QT\nVV\nPP\nII\nTM0\nME0000108001000\n");
  EXPECT_TRUE(bench.driver->info().warnings.empty());
}

TEST(ScipDialogue, RefusalsAreToldInWordsAndAskedAgainUntilTheyEnd) {
  for (const char* status : {"10", "0L", "0M", "0A", "04", "55"}) {
    ScipBench bench({}, without_comparison());
    bench.sensor.options().refusals["ME"] = status;
    bench.run(5s);
    EXPECT_TRUE(bench.scans.empty());
    EXPECT_TRUE(bench.has_warning("status " + std::string(status) + ": ")) << status;
    bench.sensor.options().refusals.clear();
    bench.run(2s);
    EXPECT_GT(bench.scans.size(), 30U) << status;
    EXPECT_TRUE(bench.driver->info().warnings.empty()) << status;
    EXPECT_EQ(bench.reconnects, 0) << status;
  }
}

TEST(ScipDialogue, ARefusalIsStillToldWhenTheSensorFallsSilentAfterIt) {
  ScipBench bench({}, without_comparison());
  bench.sensor.options().refusals["ME"] = "0L";
  bench.run(3s);
  bench.muted = true;
  bench.run(10s);
  EXPECT_TRUE(bench.has_warning("status 0L: "));
  EXPECT_TRUE(bench.has_warning("the connection is made again"));
}

TEST(ScipDialogue, ASensorThatVerifiesItselfIsGivenTime) {
  ScipBench bench({}, without_comparison());
  bench.run(1s);
  bench.sensor.tell_status("21", bench.now);
  bench.muted = false;
  bench.run(5ms);
  EXPECT_TRUE(bench.has_warning("check an error"));
  bench.run(1s);
  EXPECT_TRUE(bench.driver->info().warnings.empty()) << "scans go on";
  EXPECT_EQ(bench.written, "QT\nVV\nPP\nII\nME0000108001000\n");
}

TEST(ScipDialogue, AWrongNumberOfValuesStartsTheStreamAgain) {
  ScipBench bench({}, without_comparison());
  bench.run(1s);
  const std::size_t before = bench.scans.size();
  bench.sensor.options().values_missing = 3;
  bench.run(100ms);
  bench.sensor.options().values_missing = 0;
  bench.run(1s);
  EXPECT_EQ(bench.written, "QT\nVV\nPP\nII\nME0000108001000\nQT\nME0000108001000\n");
  EXPECT_GT(bench.scans.size(), before + 30);
  EXPECT_FALSE(bench.has_warning("another number"));
}

TEST(ScipDialogue, ASensorThatDoesNotAnswerIsLeftAndTriedAgain) {
  ScipBench bench;
  bench.muted = true;
  bench.run(2s);
  EXPECT_TRUE(bench.has_warning("does not answer QT"));
  EXPECT_EQ(bench.reconnects, 0) << "it may be slow";
  bench.run(10s);
  EXPECT_EQ(bench.reconnects, 1);
  bench.muted = false;
  bench.run(3s);
  EXPECT_GT(bench.scans.size(), 30U);
  EXPECT_TRUE(bench.driver->info().warnings.empty());
}

TEST(ScipDialogue, ASensorThatTakesSecondsForEachAnswerGetsThrough) {
  for (const Span way : {3s, 8s}) {
    ScipBench bench;
    bench.way_up = way;
    bench.run(8 * way);
    EXPECT_EQ(bench.reconnects, 0);
    EXPECT_GT(bench.scans.size(), 30U);
    EXPECT_TRUE(bench.driver->info().warnings.empty());
  }
}

TEST(ScipDialogue, AStreamThatStopsIsAskedForAgainThenTheConnectionIsMadeAnew) {
  ScipBench bench({}, without_comparison());
  bench.run(1s);
  bench.muted = true;
  bench.run(700ms);
  EXPECT_EQ(bench.reconnects, 0);
  EXPECT_EQ(bench.written, "QT\nVV\nPP\nII\nME0000108001000\nQT\n");
  bench.run(2500ms);
  EXPECT_EQ(bench.reconnects, 1);
  EXPECT_TRUE(bench.has_warning("stopped sending"));
}

TEST(ScipDialogue, APowerCycleReadsEverythingAgainAndScansComeWithinTwoSeconds) {
  ScipBench bench;
  bench.run(3s);
  const std::size_t before = bench.scans.size();
  bench.sensor.options().boot = 4s;
  bench.written.clear();
  bench.sensor.power_cycle(bench.now);
  bench.disconnect_now();
  bench.run(4s);
  EXPECT_EQ(bench.scans.size(), before);
  EXPECT_EQ(bench.written.substr(0, 12), "QT\nVV\nPP\nII\n");
  bench.run(2s);
  EXPECT_GT(bench.scans.size(), before + 20);
  EXPECT_EQ(bench.driver->counters().clock_steps, 1U) << "its counter began anew";
  EXPECT_EQ(bench.driver->counters().lost_packets, 0U);
  EXPECT_TRUE(bench.driver->info().warnings.empty());
  EXPECT_NEAR(seconds(bench.scans.back().stamp - bench.sweeps.back()), 0, 1e-3);
}

TEST(ScipDialogue, AnotherSensorInItsPlaceIsNamed) {
  ScipBench bench;
  bench.run(1s);
  bench.sensor.options().serial = "H7654321";
  bench.sensor.options().product = "UTM-30LX-EW";
  bench.sensor.options().last_step = 800;
  bench.disconnect_now();
  bench.run(1s);
  EXPECT_TRUE(bench.has_warning("sensor H1234567 was replaced by sensor H7654321"));
  EXPECT_TRUE(bench.has_warning("it is a UTM-30LX-EW, not a UST-10LX"));
  EXPECT_TRUE(bench.has_warning("number or the angles of the beams changed"));
  EXPECT_EQ(bench.scans.back().beams, 801U);
}

TEST(ScipDialogue, ScansOfAFormerStreamAreSetAside) {
  ScipBench bench({}, without_comparison());
  // A former client's stream goes on until QT arrives.
  bench.sensor.receive("MD0000050001000\n", bench.now - 100ms);
  bench.run(1s);
  ASSERT_FALSE(bench.scans.empty());
  EXPECT_EQ(bench.scans[0].beams, 1081U);
  EXPECT_TRUE(bench.driver->info().warnings.empty());
}

}  // namespace
}  // namespace lidard::test
