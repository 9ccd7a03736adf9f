// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Which sweeps of scanners that run freely are merged with each other (policy `complete`).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "test/core/merge/scheduler_bench.h"

namespace lidard {
namespace {

using test::FreeScanner;
using test::Schedule;

/// The outputs from `from` to `to` ms.
Schedule run(const std::vector<FreeScanner>& scanners, double from, double to,
             const ScheduleSettings& settings = {}) {
  return Schedule(scanners, to, settings).skip_to(from);
}

TEST(SchedulerPairs, SweepsOfScannersOfOneRateAreMergedWithTheNearestWhateverTheirPhaseAndOrder) {
  for (int phase = 0; phase < 25; ++phase) {
    for (const double first : {0.0, 25.0}) {  // which scanner is there first
      const Schedule paired = run({{25, first}, {25, static_cast<double>(phase)}}, 300, 3000);
      EXPECT_NEAR(paired.worst_skew(), std::min(phase, 25 - phase), 1e-6) << phase << " ms, from " << first;
      EXPECT_NEAR(paired.rate(), 40, 0.01) << phase;
      EXPECT_NEAR(paired.longest_gap(), 25, 1e-6) << phase;
    }
  }
}

TEST(SchedulerPairs, ScannersThatDriftAreNeverMoreThanHalfAPeriodApartAndLoseNoOutput) {
  for (const double other : {24.95, 25.05, 25.5, 26.5}) {
    for (const bool swapped : {false, true}) {
      std::vector<FreeScanner> scanners{{25, 3}, {other, 11}};
      if (swapped) std::swap(scanners[0], scanners[1]);
      const Schedule paired = run(scanners, 500, 30000);
      EXPECT_LE(paired.worst_skew(), 1.03 * std::max(other, 25.0) / 2) << other;
      EXPECT_GE(paired.rate(), 1000 / std::max(other, 25.0) - 0.05) << other;
      EXPECT_LE(paired.longest_gap(), 1.52 * std::max(other, 25.0))
          << "where the pairs change, once per slip";
    }
  }
}

TEST(SchedulerPairs, FasterScannerIsWaitedForByTheDeadlineAtMost) {
  for (const double deadline : {2.0, 7.5, 12.5}) {
    ScheduleSettings settings;
    settings.deadline = ms(deadline);
    const Schedule paired = run({{100, 3}, {25.03, 11}}, 500, 60000, settings);
    EXPECT_NEAR(paired.rate(), 10, 0.01);
    EXPECT_LE(paired.worst_skew(), 25.03 - deadline + 0.5) << deadline;
    for (const Schedule::Output& output : paired.outputs) {
      EXPECT_LE(1000 * seconds(output.at) - output.ends[0], deadline + 1e-3);
      EXPECT_NE(output.use[1], 0);
    }
  }
}

TEST(SchedulerPairs, JitterOfStampsAndOfArrivalsCostsNoOutput) {
  for (const double jitter : {0.2, 1.0, 3.0}) {
    for (const double phase : {0.0, 6.0, 12.5, 19.0}) {
      const FreeScanner of_stamps{25, phase, 1e9, 1e9, 0, 0, jitter},
          of_arrivals{25, phase, 1e9, 1e9, 12, jitter};
      for (const FreeScanner& other : {of_stamps, of_arrivals}) {
        const Schedule paired = run({{25, 0, 1e9, 1e9, 0, 0, jitter}, other}, 500, 30000);
        EXPECT_GE(paired.rate(), 39.95) << jitter << " ms at " << phase;
        EXPECT_LE(paired.worst_skew(), 12.5 + 2 * jitter + 0.4) << jitter << " ms at " << phase;
      }
    }
  }
}

TEST(SchedulerPairs, ThreeScannersThatDriftKeepTheRateOfTheSlowest) {
  const Schedule paired = run({{25, 0}, {25.05, 8.3}, {25.12, 16.6}}, 500, 60000);
  EXPECT_GE(paired.rate(), 1000 / 25.12 - 0.01);
  EXPECT_LE(paired.worst_skew(), 0.76 * 25.12);
  const Schedule mixed = run({{100, 0}, {66, 8.3}, {25.12, 16.6}}, 500, 60000);
  EXPECT_GE(mixed.rate(), 9.99);
}

TEST(SchedulerPairs, SweepThatComesTooLateMakesOneOutputWithoutItsScannerAndNoneWhenItComes) {
  for (int phase = 0; phase < 25; ++phase) {
    for (const double late : {7.6, 9.0, 20.0}) {
      for (const bool swapped : {false, true}) {
        std::vector<FreeScanner> scanners{{25, 0}, {25, static_cast<double>(phase)}};
        scanners[1].late_at = 1000, scanners[1].late_by = late;
        if (swapped) std::swap(scanners[0], scanners[1]);
        const std::size_t late_one = swapped ? 0 : 1;
        const Schedule paired = run(scanners, 500, 2000);
        const double due = std::floor((1000 - phase) / 25.0) * 25 + phase;
        std::size_t at_deadline = 0, at_arrival = 0;
        for (const Schedule::Output& output : paired.outputs) {
          const double at = 1000 * seconds(output.at);
          if (std::abs(at - due - 7.5) < 1e-3) {
            ++at_deadline;
            EXPECT_EQ(output.use[late_one], 0) << phase;
          }
          const bool on_time = std::fmod(at, 25) < 1e-3 || std::fmod(at - phase, 25) < 1e-3;
          if (!on_time && std::abs(at - due - late) < 1e-3) ++at_arrival;
        }
        EXPECT_EQ(at_deadline, 1U) << phase << " ms, late by " << late;
        EXPECT_EQ(at_arrival, 0U) << phase << " ms, late by " << late;
        EXPECT_NEAR(paired.outputs.back().skew(), std::min(phase, 25 - phase), 1e-6) << "pairs are as before";
      }
    }
  }
}

TEST(SchedulerPairs, ScannerThatDiesLeavesTheOthersAtTheirRateAndWithoutItsOldSweep) {
  for (const double phase : {1.0, 8.0, 12.5, 20.0}) {
    const Schedule paired = run({{25, 0}, {25, phase, 1000}}, 500, 3000);
    EXPECT_LE(paired.longest_gap(), 25 + 7.5 + 1e-3) << phase;
    for (const Schedule::Output& output : paired.outputs) {
      EXPECT_NE(output.use[0], 0);
      if (output.use[1] != 0) {
        EXPECT_LE(1000 * seconds(output.at) - output.ends[1], 25 + 7.5 + 1e-3) << phase;
      }
    }
    const Schedule later = run({{25, 0}, {25, phase, 1000}}, 1100, 3000);
    EXPECT_NEAR(later.rate(), 40, 0.01);
  }
}

}  // namespace
}  // namespace lidard
