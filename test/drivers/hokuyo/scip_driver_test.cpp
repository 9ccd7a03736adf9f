// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fstream>

#include "drivers/hokuyo/models.h"
#include "drivers/registry/registry.h"
#include "test/drivers/hokuyo/scip_bench.h"
#include "test/support/captures.h"

namespace lidard::test {
namespace {

using namespace std::chrono_literals;
using sim::ScipDeviceOptions;

std::string content(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// What a sensor sends while nobody of ours asks: the answers in a capture.
std::string recording(ScipDeviceOptions options, const std::string& request, Span time,
                      std::vector<sim::ScipStep> steps = scip_wall(1081)) {
  const Stamp begin = scip_epoch;
  sim::ScipDevice device(
      std::move(options), [&steps](Stamp) { return steps; }, begin - 100s);
  device.connected(begin);
  device.receive(request + "\n", begin);
  std::string all;
  while (const auto sent = device.next(begin + time)) all += sent->bytes;
  return all;
}

DriverConfig with_echoes() {
  DriverConfig config;
  config.publish_multiecho = true;
  return config;
}

TEST(ScipDriver, DecodesRealAnswers) {
  LIDARD_NEED_CAPTURE(one, "hokuyo/MD_100_110_0.scip");
  LIDARD_NEED_CAPTURE(two, "hokuyo/MD_100_110_1.scip");
  TcpBench bench("hokuyo_ust_10lx");
  EXPECT_EQ(bench.feed(content(one), true), Reject::none);
  bench.now = bench.now + 25ms;
  EXPECT_EQ(bench.feed(content(two)), Reject::none);
  ASSERT_EQ(bench.scans.size(), 2U);
  const PlanarScan& first = bench.scans[0];
  ASSERT_EQ(first.beams, 11U);
  EXPECT_NEAR(first.angle_min, -110 * rad_per_deg, 1e-6);
  EXPECT_NEAR(first.angle_max, -107.5 * rad_per_deg, 1e-6);
  for (std::size_t i = 0; i < 9; ++i) EXPECT_EQ(first.statuses[i], BeamStatus::none) << "65533 mm";
  EXPECT_FLOAT_EQ(first.ranges[9], 1.688F);  // 0JH: 26 * 64 + 24
  EXPECT_FLOAT_EQ(first.ranges[10], 1.690F);
  EXPECT_FLOAT_EQ(bench.scans[1].ranges[9], 1.689F);
  EXPECT_NEAR(seconds(bench.scans[1].stamp - first.stamp), 0.025, 0.002) << "the counter shows 24 ms";
  EXPECT_EQ(bench.driver->counters().rejected_total(), 0U);
  EXPECT_EQ(bench.driver->counters().packets, 2U);
}

TEST(ScipDriver, DecodesRealSingleAnswersWithIntensities) {
  LIDARD_NEED_CAPTURE(distances, "hokuyo/GD_0_10.scip");
  LIDARD_NEED_CAPTURE(with_intensities, "hokuyo/GE_0_10.scip");
  TcpBench plain("hokuyo_ust_10lx"), bright("hokuyo_ust_10lx");
  EXPECT_EQ(plain.feed(content(distances), true), Reject::none);
  EXPECT_EQ(bright.feed(content(with_intensities), true), Reject::none);
  ASSERT_EQ(plain.scans.size(), 1U);
  ASSERT_EQ(bright.scans.size(), 1U);
  ASSERT_EQ(plain.scans[0].beams, 11U);
  EXPECT_TRUE(plain.scans[0].intensities.empty());
  // 063: 6 * 64 + 3.
  EXPECT_FLOAT_EQ(plain.scans[0].ranges[0], 0.387F);
  ASSERT_EQ(bright.scans[0].intensities.size(), 11U);
  // 0NC: 30 * 64 + 19; 0<O: 12 * 64 + 31.
  EXPECT_FLOAT_EQ(bright.scans[0].ranges[0], 1.939F);
  EXPECT_FLOAT_EQ(bright.scans[0].intensities[0], 799);
  // This beam straddles the line end: 0Gj0 and :c.
  EXPECT_FLOAT_EQ(bright.scans[0].ranges[10], 1.530F);
  EXPECT_FLOAT_EQ(bright.scans[0].intensities[10], 691);
}

TEST(ScipDriver, ReadsEveryKindOfRequestAlike) {
  for (const char* request : {"MD0000108001000", "MS0000108001000", "ME0000108001000", "ND0000108001000",
                              "NE0000108001000", "%MD0000108001000", "%ME0000108001000", "GD0000108001",
                              "GS0000108001", "GE0000108001", "HD0000108001", "HE0000108001"}) {
    ScipDeviceOptions options;
    options.knows_percent = options.knows_echoes = true;
    TcpBench bench("hokuyo_utm_30lx_ew");
    EXPECT_EQ(bench.feed(recording(options, request, 100ms), true), Reject::none) << request;
    ASSERT_GE(bench.scans.size(), 1U) << request;
    const PlanarScan& scan = bench.scans[0];
    ASSERT_EQ(scan.beams, 1081U);
    for (std::size_t i = 0; i < scan.beams; ++i) {
      ASSERT_FLOAT_EQ(scan.ranges[i], 1.0F + 0.001F * static_cast<float>(i)) << request;
      if (!scan.intensities.empty()) {
        ASSERT_EQ(scan.intensities[i], 2.0F * static_cast<float>(i));
      }
    }
    const bool asked = std::string(request).find('E') != std::string::npos;
    EXPECT_EQ(!scan.intensities.empty(), asked) << request;
    EXPECT_EQ(bench.driver->counters().rejected_total(), 0U);
  }
}

TEST(ScipDriver, FurtherEchoesFollowTheFirstAndMayStandAtALineEnd) {
  ScipDeviceOptions options;
  options.knows_echoes = true;
  std::vector<sim::ScipStep> steps = scip_wall(1081);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (i % 3 > 0) steps[i].push_back({5000, 7});
    if (i % 3 > 1) steps[i].push_back({9000, 8});
  }
  for (const char* request : {"ND0000108001000", "NE0000108001000"}) {
    TcpBench bench("hokuyo_utm_30lx_ew", with_echoes()), single("hokuyo_utm_30lx_ew");
    const std::string stream = recording(options, request, 100ms, steps);
    EXPECT_EQ(bench.feed(stream, true), Reject::none);
    EXPECT_EQ(single.feed(stream, true), Reject::none);
    ASSERT_GE(bench.scans.size(), 1U);
    const PlanarScan& scan = bench.scans[0];
    ASSERT_EQ(scan.echoes, 3U);
    for (std::size_t i = 0; i < scan.beams; ++i) {
      EXPECT_FLOAT_EQ(scan.ranges[scan.index(i, 0)], 1.0F + 0.001F * static_cast<float>(i));
      const BeamStatus second = i % 3 > 0 ? BeamStatus::hit : BeamStatus::invalid;
      ASSERT_EQ(scan.statuses[scan.index(i, 1)], second);
      if (i % 3 > 1) {
        ASSERT_FLOAT_EQ(scan.ranges[scan.index(i, 2)], 9.0F);
      }
    }
    ASSERT_EQ(single.scans.at(0).echoes, 1U);
    EXPECT_EQ(single.scans[0].ranges[2], scan.ranges[2]);
  }
}

TEST(ScipDriver, CodesAndDistancesBeyondTheRangeAreNeverRanges) {
  std::vector<sim::ScipStep> steps = scip_wall(1081);
  for (unsigned code = 0; code < 20; ++code) steps[code] = {{code, 0}};
  steps[20] = {{20, 0}};
  steps[21] = {{30000, 0}};
  steps[22] = {{30001, 0}};
  steps[23] = {{65533, 0}};
  steps[24] = {{262143, 0}};
  TcpBench bench("hokuyo_ust_10lx");
  bench.feed(recording({}, "MD0000108001000", 100ms, steps), true);
  ASSERT_GE(bench.scans.size(), 1U);
  const PlanarScan& scan = bench.scans[0];
  EXPECT_EQ(scan.statuses[1], BeamStatus::none);
  EXPECT_EQ(scan.statuses[2], BeamStatus::near);
  EXPECT_EQ(scan.statuses[4], BeamStatus::near);
  for (const std::size_t i : {0U, 3U, 5U, 6U, 19U}) EXPECT_EQ(scan.statuses[i], BeamStatus::invalid) << i;
  EXPECT_EQ(scan.statuses[20], BeamStatus::hit);
  EXPECT_EQ(scan.statuses[21], BeamStatus::hit);
  for (const std::size_t i : {22U, 23U, 24U}) EXPECT_EQ(scan.statuses[i], BeamStatus::none) << i;
}

TEST(ScipDriver, TwoCharactersEndAtFourMetres) {
  std::vector<sim::ScipStep> steps = scip_wall(1081);
  steps[5] = {{9000, 0}};
  TcpBench bench("hokuyo_ust_10lx");
  bench.feed(recording({}, "MS0000108001000", 100ms, steps), true);
  ASSERT_GE(bench.scans.size(), 1U);
  EXPECT_EQ(bench.scans[0].statuses[5], BeamStatus::none);
  EXPECT_FLOAT_EQ(bench.scans[0].range_max, 4.094F);
}

TEST(ScipDriver, AGroupPointsToItsMiddle) {
  TcpBench bench("hokuyo_ust_10lx");
  bench.feed(recording({}, "MD0100020003000", 100ms), true);
  ASSERT_GE(bench.scans.size(), 1U);
  const PlanarScan& scan = bench.scans[0];
  ASSERT_EQ(scan.beams, 34U) << "floor(100 / 3) + 1";
  EXPECT_NEAR(scan.angle_min, (101 - 540) * 0.25 * rad_per_deg, 1e-6);
  EXPECT_NEAR(scan.angle_increment, 0.75 * rad_per_deg, 1e-8);
  EXPECT_FLOAT_EQ(scan.ranges[1], 1.103F) << "the least of steps 103 to 105";
}

TEST(ScipDriver, ParametersInACaptureReplaceThoseOfTheTable) {
  ScipDeviceOptions options;
  options.product = "URG-04LX";
  options.range_min_mm = 20, options.range_max_mm = 5600;
  options.steps_per_turn = 1024, options.first_step = 44, options.last_step = 725, options.front_step = 384;
  options.rpm = 600;
  std::vector<sim::ScipStep> steps = scip_wall(726);
  steps[50] = {{6, 0}};
  steps[51] = {{7, 0}};
  TcpBench bench("hokuyo_scip");
  bench.feed(recording(options, "PP\nMD0044072501000", 400ms, steps), true);
  ASSERT_GE(bench.scans.size(), 1U);
  const PlanarScan& scan = bench.scans[0];
  EXPECT_EQ(scan.beams, 682U);
  EXPECT_NEAR(scan.angle_min, (44 - 384) * 2 * 3.14159265358979 / 1024, 1e-6);
  EXPECT_FLOAT_EQ(scan.range_max, 5.6F);
  EXPECT_NEAR(scan.scan_time, 0.1, 1e-6);
  EXPECT_EQ(scan.statuses[6], BeamStatus::none) << "code 6 of a URG";
  EXPECT_EQ(scan.statuses[7], BeamStatus::invalid);
  EXPECT_EQ(bench.detail("Product Name"), "URG-04LX");
}

// Fields of view of the data sheets: UST and UTM 270 deg, UXM 190 deg, all about the front.
TEST(ScipDriver, WithoutParametersInACaptureTheFieldOfViewIsThatOfTheDataSheet) {
  for (const auto& [model, last, fov] : {std::tuple{"hokuyo_ust_05lx", 1080, 270},
                                         {"hokuyo_ust_10lx", 1080, 270},
                                         {"hokuyo_ust_20lx", 1080, 270},
                                         {"hokuyo_ust_30lx", 1080, 270},
                                         {"hokuyo_utm_30lx_ew", 1080, 270},
                                         {"hokuyo_uxm_30lx_ew", 760, 190}}) {
    SCOPED_TRACE(model);
    ScipDeviceOptions options;
    options.last_step = last;
    TcpBench bench(model);
    const std::string end = last == 1080 ? "1080" : "0760";
    bench.feed(recording(options, "MD0000" + end + "00000", 200ms, scip_wall(last + 1)), true);
    ASSERT_GE(bench.scans.size(), 1U);
    EXPECT_NEAR(bench.scans[0].angle_min, -fov * rad_per_deg / 2, 1e-5);
    EXPECT_NEAR(bench.scans[0].angle_max, fov * rad_per_deg / 2, 1e-5);
  }
}

TEST(ScipDriver, ParametersThatCannotBeUsedAreAWarningAndTheTableStands) {
  TcpBench bench("hokuyo_ust_10lx");
  bench.feed(std::string("PP\n00P\nMODL:URG-04LX;") + hokuyo::scip_checksum("MODL:URG-04LX") + "\n\n", true);
  EXPECT_TRUE(bench.has_warning("the sensor's answer to PP cannot be used"));
  EXPECT_EQ(bench.detail("Product Name"), "UST-10LX");
}

TEST(ScipDriver, TheStampIsThatOfStepZero) {
  for (const bool percent : {false, true}) {
    ScipDeviceOptions options;
    options.knows_percent = true;
    TcpBench all("hokuyo_ust_10lx"), late("hokuyo_ust_10lx");
    const std::string prefix = percent ? "%" : "";
    // Both devices are the same one at the same time.
    all.feed(recording(options, prefix + "MD0000108001000", 100ms), true);
    late.feed(recording(options, prefix + "MD0360108001000", 100ms), true);
    ASSERT_GE(all.scans.size(), 1U);
    ASSERT_GE(late.scans.size(), 1U);
    // Stamps are placed by the arrival of the last step, which is the same in both.
    EXPECT_NEAR(seconds(late.scans[0].stamp - all.scans[0].stamp), 0.025 / 4, 1e-6);
  }
}

TEST(ScipDriver, OtherStepsInACaptureAreSetAsideUntilTheyStay) {
  TcpBench bench("hokuyo_ust_10lx");
  bench.feed(recording({}, "MD0000108001000", 200ms), true);
  const std::size_t before = bench.scans.size();
  ASSERT_GT(before, 3U);
  bench.feed(recording({}, "GD0000001001", 200ms));
  EXPECT_EQ(bench.scans.size(), before);
  EXPECT_TRUE(bench.driver->info().warnings.empty());
  bench.feed(recording({}, "MD0100020001000", 600ms));
  EXPECT_TRUE(bench.has_warning("number or the angles of the beams changed"));
  EXPECT_EQ(bench.scans.back().beams, 101U);
}

TEST(ScipDriver, WrongLinesAreCountedByTheirReason) {
  const std::string good = recording({}, "MD0000108001000", 60ms);
  const auto with = [&](std::size_t at, char c) {
    std::string bad = good;
    bad[at] = c;
    TcpBench bench("hokuyo_ust_10lx");
    bench.feed(bad, true);
    return bench.driver->counters();
  };
  const std::size_t stamp = good.find("99b\n") + 4;
  const std::size_t data = stamp + 6;
  EXPECT_EQ(with(stamp, 'o').rejected[static_cast<std::size_t>(Reject::checksum)], 1U);
  EXPECT_EQ(with(data + 10, 'o').rejected[static_cast<std::size_t>(Reject::checksum)], 1U);
  EXPECT_EQ(with(good.find("99b") + 2, 'x').rejected[static_cast<std::size_t>(Reject::magic)], 1U);
  ScipDeviceOptions defect;
  defect.values_missing = 2;
  TcpBench bench("hokuyo_ust_10lx");
  bench.feed(recording(defect, "MD0000108001000", 60ms), true);
  EXPECT_TRUE(bench.scans.empty());
  EXPECT_GE(bench.driver->counters().rejected[static_cast<std::size_t>(Reject::size)], 1U);
  EXPECT_TRUE(bench.has_warning("another number of distances"));
}

}  // namespace
}  // namespace lidard::test
