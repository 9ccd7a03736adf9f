// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Which sweeps of scanners that run freely are merged with each other (policy `complete`).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "core/merge/scheduler.h"
#include "test/sim/world/rng.h"
#include "test/sim/world/units.h"

namespace lidard {
namespace {

constexpr Stamp first_ray{1'700'000'000'000'000'000};

struct FreeScanner {
  double period, phase;                  // ms
  double silent_from = 1e9, back = 1e9;  // ms
  double jitter = 0;                     // ms, of the last ray's stamp, +-
  double delay = 0, delay_jitter = 0;    // ms, from the last ray to the arrival
  double late_at = -1, late_by = 0;      // ms, one sweep that arrives late
};

struct PairedOutput {
  double at;                                // ms
  std::vector<std::optional<double>> ends;  // ms, of the sweeps used; none: without this scanner
  double skew() const {
    double first = 1e9, last = -1e9;
    for (const auto& end : ends) {
      if (end) first = std::min(first, *end), last = std::max(last, *end);
    }
    return last - first;
  }
};

struct Paired {
  std::vector<PairedOutput> outputs;

  double rate() const {
    return 1000 * static_cast<double>(outputs.size() - 1) / (outputs.back().at - outputs.front().at);
  }
  double worst_skew() const {
    double worst = 0;
    for (const PairedOutput& output : outputs) worst = std::max(worst, output.skew());
    return worst;
  }
  double longest_gap() const {
    double longest = 0;
    for (std::size_t i = 1; i < outputs.size(); ++i)
      longest = std::max(longest, outputs[i].at - outputs[i - 1].at);
    return longest;
  }
};

/// The outputs from `from` to `to` (ms).
Paired run(const std::vector<FreeScanner>& scanners, double from, double to,
           const ScheduleSettings& settings = {}) {
  struct Sweep {
    double arrival, end;
    std::size_t source;
  };
  std::vector<Sweep> sweeps;
  sim::Rng rng(7);
  for (std::size_t s = 0; s < scanners.size(); ++s) {
    const FreeScanner& c = scanners[s];
    for (double due = c.phase; due < to + 1000; due += c.period) {
      const double end = due + c.jitter * (2 * rng.uniform() - 1);
      const double late = due <= c.late_at && c.late_at < due + c.period ? c.late_by : 0;
      const double arrival = end + c.delay + c.delay_jitter * rng.uniform() + late;
      if (arrival < c.silent_from || arrival >= c.back) sweeps.push_back({arrival, end, s});
    }
  }
  std::stable_sort(sweeps.begin(), sweeps.end(), [](auto& a, auto& b) { return a.arrival < b.arrival; });
  Scheduler scheduler(scanners.size(), settings);
  std::vector<double> newest(scanners.size(), 0);
  Paired paired;
  for (auto next = sweeps.begin();;) {
    Stamp now = first_ray + ms(next->arrival);
    const auto event = scheduler.next_event();
    if (event && *event < now) {
      now = *event;
    } else {
      newest[next->source] = next->end;
      scheduler.delivered(next->source, first_ray + ms(next->end), scanners[next->source].period / 1000, now);
      ++next;
    }
    const double at = 1000 * seconds(now - first_ray);
    if (at >= to) return paired;
    if (!scheduler.is_due(now)) continue;
    PairedOutput output{at, {}};
    for (std::size_t s = 0; s < newest.size(); ++s)
      output.ends.push_back(scheduler.usable(now)[s] != 0 ? std::optional(newest[s]) : std::nullopt);
    scheduler.done(now);
    if (at >= from) paired.outputs.push_back(output);
  }
}

TEST(SchedulerPairs, SweepsOfScannersOfOneRateAreMergedWithTheNearestWhateverTheirPhaseAndOrder) {
  for (int phase = 0; phase < 25; ++phase) {
    for (const double first : {0.0, 25.0}) {  // which scanner is there first
      const Paired paired = run({{25, first}, {25, static_cast<double>(phase)}}, 300, 3000);
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
      const Paired paired = run(scanners, 500, 30000);
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
    const Paired paired = run({{100, 3}, {25.03, 11}}, 500, 60000, settings);
    EXPECT_NEAR(paired.rate(), 10, 0.01);
    EXPECT_LE(paired.worst_skew(), 25.03 - deadline + 0.5) << deadline;
    for (const PairedOutput& output : paired.outputs) {
      EXPECT_LE(output.at - *output.ends[0], deadline + 1e-3);
      EXPECT_TRUE(output.ends[1].has_value());
    }
  }
}

TEST(SchedulerPairs, JitterOfStampsAndOfArrivalsCostsNoOutput) {
  for (const double jitter : {0.2, 1.0, 3.0}) {
    for (const double phase : {0.0, 6.0, 12.5, 19.0}) {
      const FreeScanner of_stamps{25, phase, 1e9, 1e9, jitter},
          of_arrivals{25, phase, 1e9, 1e9, 0, 12, jitter};
      for (const FreeScanner& other : {of_stamps, of_arrivals}) {
        const Paired paired = run({{25, 0, 1e9, 1e9, jitter}, other}, 500, 30000);
        EXPECT_GE(paired.rate(), 39.95) << jitter << " ms at " << phase;
        EXPECT_LE(paired.worst_skew(), 12.5 + 2 * jitter + 0.4) << jitter << " ms at " << phase;
      }
    }
  }
}

TEST(SchedulerPairs, ThreeScannersThatDriftKeepTheRateOfTheSlowest) {
  const Paired paired = run({{25, 0}, {25.05, 8.3}, {25.12, 16.6}}, 500, 60000);
  EXPECT_GE(paired.rate(), 1000 / 25.12 - 0.01);
  EXPECT_LE(paired.worst_skew(), 0.76 * 25.12);
  const Paired mixed = run({{100, 0}, {66, 8.3}, {25.12, 16.6}}, 500, 60000);
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
        const Paired paired = run(scanners, 500, 2000);
        const double due = std::floor((1000 - phase) / 25.0) * 25 + phase;
        std::size_t at_deadline = 0, at_arrival = 0;
        for (const PairedOutput& output : paired.outputs) {
          if (std::abs(output.at - due - 7.5) < 1e-3) {
            ++at_deadline;
            EXPECT_FALSE(output.ends[late_one].has_value()) << phase;
          }
          const bool on_time = std::fmod(output.at, 25) < 1e-3 || std::fmod(output.at - phase, 25) < 1e-3;
          if (!on_time && std::abs(output.at - due - late) < 1e-3) ++at_arrival;
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
    const Paired paired = run({{25, 0}, {25, phase, 1000}}, 500, 3000);
    EXPECT_LE(paired.longest_gap(), 25 + 7.5 + 1e-3) << phase;
    for (const PairedOutput& output : paired.outputs) {
      EXPECT_TRUE(output.ends[0].has_value());
      if (output.ends[1]) {
        EXPECT_LE(output.at - *output.ends[1], 25 + 7.5 + 1e-3) << phase;
      }
    }
    const Paired later = run({{25, 0}, {25, phase, 1000}}, 1100, 3000);
    EXPECT_NEAR(later.rate(), 40, 0.01);
  }
}

}  // namespace
}  // namespace lidard
