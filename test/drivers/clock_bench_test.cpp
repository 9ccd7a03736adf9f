// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Simulated devices of every family on a virtual clock: drift, jitter, overflows, reboots, a host whose clock
// is set. `report_clocks` prints the figures behind the limits.
#include "test/support/clock_bench.h"

#include <gtest/gtest.h>

#include <string>

#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "test/support/clock_scenarios.h"
#include "test/support/collector.h"

namespace lidard::test {
namespace {

using namespace std::chrono_literals;

/// Whole ms do not tell where in one a turn of a motor begins that is in step with the counter.
bool has_beat(const BenchFamily& family) {
  return std::string(family.name).find("in step") == std::string::npos;
}
bool is_on_tick(const BenchFamily& family) {
  return std::string(family.name).find("on its tick") != std::string::npos;
}
bool is_cloud(const BenchFamily& family) { return find_model(family.model)->kind == FrameKind::cloud; }
bool is_jittery(const BenchScenario& scenario) { return scenario.jitter > 1ms; }

/// What is allowed, s: 99 % of the scans of sensors with whole ms. A sensor that sends on its tick leaves
/// only half of its arrivals to tell the time by; one whose motor is in step hides up to half a ms.
double allowed_p99(const BenchFamily& family, const BenchScenario& scenario) {
  if (!has_beat(family)) return 1e-3;
  return is_jittery(scenario) && is_on_tick(family) ? 1.3e-3 : 0.5e-3;
}
/// Root mean square, s, of sensors with us: of 15 scans in a second, few are early where each may be 5 ms
/// late.
double allowed_rms(const BenchFamily& family, const BenchScenario& scenario) {
  return is_jittery(scenario) && family.period > 0.06 && !is_cloud(family) ? 0.25e-3 : 0.2e-3;
}

/// s: rates that change show after 1.6 s only, in which the clocks have drifted by 0.8 ms.
constexpr double allowed_while_slewed = 2.5e-3;

class ClockBench : public testing::TestWithParam<std::size_t> {
 protected:
  const BenchFamily& family() const { return bench_families()[GetParam()]; }
};

TEST_P(ClockBench, StampsAreRightFromTwoSecondsOnAndNoScanIsDropped) {
  std::size_t number = 0;
  for (const BenchScenario& scenario : clock_scenarios()) {
    // Clouds take long to simulate.
    if (is_cloud(family()) && number++ % 3 != 0) continue;
    const std::string what = std::string(family().name) + ", " + scenario.name;
    const BenchFigures seen = run_clock_bench(family(), scenario, is_cloud(family()) ? 17s : 24s, 1);
    ASSERT_GT(seen.frames, 150U) << what;
    EXPECT_EQ(seen.without_truth, 0U) << what;
    if (scenario.slew_ppm != 0)
      EXPECT_LE(seen.worst, allowed_while_slewed) << what;
    else if (family().ms_counter)
      EXPECT_LE(seen.p99, allowed_p99(family(), scenario)) << what;
    else
      EXPECT_LE(seen.rms, allowed_rms(family(), scenario)) << what;
    // A capture that jumps by a whole hour leaves the stamps of a Velodyne, which count within an hour, as
    // they are; the turn that it goes through is torn.
    const bool is_torn = scenario.recorded && is_cloud(family());
    EXPECT_EQ(seen.missing, is_torn ? 1U : 0U) << what;
    EXPECT_EQ(seen.jumps, scenario.step_at ? 1U : 0U) << what;
    EXPECT_EQ(seen.backwards, scenario.step_s < 0 ? 1U : 0U) << what;
    EXPECT_EQ(scenario.wrap ? seen.lost : 0U, 0U) << what;
    EXPECT_EQ(seen.steps, scenario.reboot || (scenario.recorded && !is_torn) ? 1U : 0U) << what;
  }
}

TEST_P(ClockBench, DiagnosticsTellTheDriftAndWhatHappenedToTheCounter) {
  BenchScenario scenario;
  scenario.name = "overflow";
  scenario.ppm = 100;
  scenario.jitter = 300us;
  scenario.wrap = 5s;
  const DeviceInfo over = run_clock_bench(family(), scenario, 8s, 1).info;
  EXPECT_EQ(detail_of(over, "Stamps"), "by the device's clock, drift measured");
  EXPECT_NEAR(std::stod(detail_of(over, "Clock drift (ppm)")), 100, 60);
  EXPECT_LE(std::stod(detail_of(over, "Clock residual (ms)")), 1);
  EXPECT_EQ(detail_of(over, "Clock restarts"), "0");
  EXPECT_EQ(detail_of(over, "Clock overflows"), family().overflows ? "1" : "0");

  scenario.wrap.reset();
  scenario.reboot = 4s;
  const DeviceInfo again = run_clock_bench(family(), scenario, 7s, 1).info;
  EXPECT_EQ(detail_of(again, "Clock restarts"), "1");
  EXPECT_EQ(detail_of(again, "Stamps"), "by the device's clock, drift not yet measured")
      << "1.5 s after the device was back";
}

TEST_P(ClockBench, TheFirstStampsAreRightToAMillisecondOnAQuietNetwork) {
  for (const BenchScenario& scenario : clock_scenarios()) {
    if (is_jittery(scenario) || scenario.outliers > 0) continue;
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
      const BenchFigures seen = run_clock_bench(family(), scenario, 3s, seed);
      EXPECT_LE(seen.first, 1e-3) << family().name << ", " << scenario.name << ", seed " << seed;
      EXPECT_LE(seen.start, 1e-3) << family().name << ", " << scenario.name << ", seed " << seed;
    }
  }
}

TEST_P(ClockBench, WhatTheNetworkKeptForAWhileIsNotPlacedAheadOfItsArrival) {
  BenchScenario scenario;
  scenario.name = "network that stalls";
  scenario.ppm = 100;
  scenario.jitter = 100us;
  for (const Span stall : {300ms, 600ms, 1500ms, 4000ms, 6000ms}) {
    scenario.stall = stall;
    const std::string what = std::string(family().name) + ", s: " + std::to_string(seconds(stall));
    const Span length = 9s + stall;
    const BenchFigures seen = run_clock_bench(family(), scenario, length, 1);
    // A device at a connection is asked again, or connected anew; what it sent meanwhile may be lost.
    const bool keeps_all = find_model(family().model)->transport == Transport::udp;
    const double least = seconds(keeps_all ? length : 8500ms) / family().period - 2;
    EXPECT_GE(static_cast<double>(seen.frames), least) << what;
    EXPECT_LE(seen.ahead, 1e-3) << what;
    EXPECT_LE(seen.worst, 2e-3) << what;
    EXPECT_EQ(seen.backwards, 0U) << what;
  }
}

std::string name_of(const testing::TestParamInfo<std::size_t>& info) {
  std::string name;
  for (const char* c = bench_families()[info.param].name; *c != '\0'; ++c) {
    if (std::isalnum(static_cast<unsigned char>(*c)) != 0) name += *c;
  }
  return name;
}

INSTANTIATE_TEST_SUITE_P(Families, ClockBench, testing::Range<std::size_t>(0, bench_families().size()),
                         name_of);

}  // namespace
}  // namespace lidard::test
