// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Safety scanners: mounted upside down, windows of angles, scans that are lost, clocks and stalls at their
// limits.
#include <gtest/gtest.h>

#include "test/drivers/sick/safety/safety_bench.h"
#include "test/sim/world/units.h"

namespace lidard::test {
namespace {

constexpr double rad = 3.14159265358979323846 / 180;

/// A scan of 270 beams of 1 deg from -45 deg of the device on; with a negative step it counts down from 224.
Ms3Sample round_sample(bool upside_down) {
  Ms3Sample sample;
  sample.beams.resize(270);
  for (std::size_t i = 0; i < 270; ++i) {
    sample.beams[i].distance = static_cast<std::uint16_t>(1000 + i);
    sample.beams[i].reflectivity = static_cast<std::uint8_t>(i % 250);
  }
  constexpr std::int32_t deg = 4194304;
  sample.start = upside_down ? 224 * deg : -45 * deg;
  sample.step = upside_down ? -deg : deg;
  sample.period_us = 83;  // 30 ms / 360
  return sample;
}

TEST(SafetyUpsideDown, BeamsGoTheOtherWayRoundAndTakeAsLong) {
  SafetyBench up, down;
  up.sample = round_sample(false);
  down.sample = round_sample(true);
  up.send_next();
  down.send_next();
  const PlanarScan &a = up.scans.at(0), &b = down.scans.at(0);
  EXPECT_GT(a.angle_increment, 0);
  EXPECT_EQ(b.angle_increment, -a.angle_increment);
  EXPECT_NEAR(b.angle_min, (224 - 90) * rad, 1e-5);
  EXPECT_NEAR(b.angle_max, (-45 - 90) * rad, 1e-5);
  EXPECT_NEAR(a.time_increment, 0.03 / 360, 1e-9);
  EXPECT_EQ(b.time_increment, a.time_increment) << "time does not run backwards";
  EXPECT_EQ(b.stamp, a.stamp);
  EXPECT_NEAR(seconds(down.now - b.stamp), 269 * 0.03 / 360, 1e-6);
}

TEST(SafetyBeamPeriod, IsTheExactOneWithinAMicrosecondOfTheAnnouncedOne) {
  const auto period = [](std::uint32_t announced_us) {
    SafetyBench bench;
    bench.sample = round_sample(false);
    bench.sample.period_us = announced_us;
    bench.send_next();
    return static_cast<double>(bench.scans.at(0).time_increment);
  };
  const double exact = 0.03 / 360;  // 83.33 us
  EXPECT_NEAR(period(83), exact, 1e-9);
  EXPECT_NEAR(period(84), exact, 1e-9);
  EXPECT_NEAR(period(82), 82e-6, 1e-9);
  EXPECT_NEAR(period(85), 85e-6, 1e-9);
}

/// Sends the scan that many numbers ahead, arriving so long after the last one.
void send_after(SafetyBench& bench, std::uint32_t scans, Span passed) {
  bench.sample.sequence += scans;
  bench.sample.scan += scans;
  bench.now = bench.now + passed;
  bench.send(bench.sample, bench.now);
}

TEST(SafetyLosses, AreTheNumbersThatAreLeftOut) {
  SafetyBench bench;
  for (int i = 0; i < 5; ++i) bench.send_next();
  EXPECT_EQ(bench.driver->counters().lost_packets, 0U);
  send_after(bench, 2, ms(60));
  EXPECT_EQ(bench.driver->counters().lost_packets, 1U);
  send_after(bench, 5, ms(150));
  EXPECT_EQ(bench.driver->counters().lost_packets, 5U);
  send_after(bench, 1, ms(30));
  EXPECT_EQ(bench.driver->counters().lost_packets, 5U);
  EXPECT_EQ(bench.driver->counters().clock_steps, 0U);
  EXPECT_EQ(bench.driver->counters().frames, 8U);
}

TEST(SafetyStamps, FollowTheScanNumbersThroughAStallAndTheArrivalsOnceAllScansOfHalfASecondWereLate) {
  for (const int late : {499, 2000}) {
    SafetyBench bench;
    for (int i = 0; i < 50; ++i) bench.send_next();
    const Stamp before = bench.scans.back().stamp;
    send_after(bench, 1, ms(30 + late));
    EXPECT_NEAR(seconds(bench.scans.back().stamp - before), 0.03, 2e-3) << late;
    for (int i = 0; i < 16; ++i) bench.send_next();
    EXPECT_EQ(bench.driver->counters().clock_steps, 0U) << late;
    for (int i = 0; i < 2; ++i) bench.send_next();
    EXPECT_EQ(bench.driver->counters().clock_steps, 1U) << late;
    EXPECT_NEAR(seconds(bench.scans.back().stamp - before), 19 * 0.03 + late * 1e-3, 2e-3) << late;
  }
}

TEST(SafetyStamps, AnotherScanTimeIsAnotherClock) {
  SafetyBench bench;
  for (int i = 0; i < 50; ++i) bench.send_next();
  bench.sample.scan_time_ms = 40;
  bench.sample.period_us = 57;
  for (int i = 0; i < 50; ++i) bench.send_next();
  EXPECT_NEAR(seconds(bench.now - bench.scans.back().stamp), 47 * 0.04 * 0.51306 / 360, 1e-4);
  EXPECT_EQ(bench.driver->counters().lost_packets, 0U);
  EXPECT_FLOAT_EQ(bench.scans.back().scan_time, 0.04F);
}

}  // namespace
}  // namespace lidard::test
