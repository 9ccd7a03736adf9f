// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// What a counter of whole milliseconds leaves open of a sweep's begin, and where SCIP's clock puts it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "drivers/hokuyo/scip_clock.h"
#include "test/drivers/hokuyo/scip_bench.h"

namespace lidard::test {
namespace {

using namespace std::chrono_literals;
using hokuyo::ScipClock;

/// A sensor whose turns take `turn` s; it shows whole ms and sends on its next tick, or at once.
struct TickingSensor {
  double turn = 0.02505;
  double until_sent = 0.018;
  bool on_tick = true;

  ScipClock::Sweep sweep(double begin) const {
    const double end = begin + until_sent;
    ScipClock::Sweep s;
    s.stamp = {static_cast<std::uint64_t>(std::floor(begin * 1e3 + 1e-9)), false};
    s.period = span_from_seconds(0.025);
    s.until_sent = span_from_seconds(until_sent);
    s.arrival = scip_epoch + span_from_seconds(on_tick ? std::ceil(end * 1e3 - 1e-9) / 1e3 : end);
    return s;
  }
};

/// Stamp minus true begin, s, of the sweeps between two times.
std::vector<double> errors_of(ScipClock& clock, const TickingSensor& sensor, double from, double to) {
  std::vector<double> errors;
  std::int64_t skipped = 0;
  for (double t = 0.0103; t < to; t += sensor.turn) {
    const Stamp begin = clock.begin_of(sensor.sweep(t), skipped);
    if (t >= from) errors.push_back(seconds(begin - (scip_epoch + span_from_seconds(t))));
  }
  return errors;
}

double spread(const std::vector<double>& errors) {
  const auto [low, high] = std::minmax_element(errors.begin(), errors.end());
  return *high - *low;
}

// A begin that lay at the start of its tick, or at its end, is as likely as one in the middle: a line through
// the ticks of many turns finds the fraction, and no stamp leaves its own tick.
TEST(ScipTick, ALineThroughTheTicksOfManyTurnsFindsTheFractionOfAMillisecond) {
  for (const double turn : {0.02505, 0.02497, 0.025013, 0.025107}) {
    TickingSensor sensor;
    sensor.turn = turn;
    ScipClock clock(ClockMode::smooth, true);
    EXPECT_LT(spread(errors_of(clock, sensor, 8, 20)), 0.25e-3) << turn;
  }
}

TEST(ScipTick, ComparedWithTheHostTheMiddleOfATickIsRight) {
  // The comparison bounds when the counter showed what it did to 0.2 ms; the sensor sends at once.
  for (const bool on_tick : {false, true}) {
    TickingSensor sensor;
    sensor.on_tick = on_tick;
    ScipClock clock(ClockMode::smooth, on_tick);
    for (double t = 0.0003; t < 0.01; t += 0.0011) {
      const hokuyo::ScipStamp shown{static_cast<std::uint64_t>(t * 1e3), false};
      clock.compare(shown, scip_epoch + span_from_seconds(t - 1e-4),
                    scip_epoch + span_from_seconds(t + 1e-4));
    }
    ASSERT_TRUE(clock.uncertainty());
    EXPECT_LE(seconds(*clock.uncertainty()), 1.2e-3);
    const auto errors = errors_of(clock, sensor, 0.5, 20);
    double mean = 0;
    for (const double error : errors) mean += error / static_cast<double>(errors.size());
    EXPECT_NEAR(mean, 0, on_tick ? 0.6e-3 : 0.3e-3) << on_tick;
    EXPECT_EQ(clock.steps(), 0U);
  }
}

TEST(ScipTick, ATurnThatIsLeftOutIsCountedOnceAndMovesNothing) {
  TickingSensor sensor;
  sensor.on_tick = false;
  ScipClock clock(ClockMode::smooth, false);
  std::int64_t skipped = 0, all = 0;
  std::vector<double> errors;
  int number = 0;
  for (double t = 0.0103; t < 20; t += sensor.turn, ++number) {
    if (number % 50 == 20 || number % 50 == 21 || number % 90 == 70) continue;
    const Stamp begin = clock.begin_of(sensor.sweep(t), skipped);
    all += skipped;
    if (t > 5) errors.push_back(seconds(begin - (scip_epoch + span_from_seconds(t))));
  }
  int expected = 0;
  for (int i = 0; i < number; ++i) expected += i % 50 == 20 || i % 50 == 21 || i % 90 == 70 ? 1 : 0;
  EXPECT_EQ(all, expected);
  EXPECT_LT(spread(errors), 0.5e-3);
  EXPECT_EQ(clock.steps(), 0U);
}

TEST(ScipTick, ACounterThatWasResetIsOneStepAndTheStampsGoOn) {
  for (const double back : {0.2, 5.0, 1000.0}) {
    TickingSensor sensor;
    sensor.on_tick = false;
    ScipClock clock(ClockMode::smooth, false);
    std::int64_t skipped = 0;
    for (double t = 1000.0103; t < 1010; t += sensor.turn) {
      ScipClock::Sweep sweep = sensor.sweep(t);
      if (t > 1005) sweep.stamp.ticks -= static_cast<std::uint64_t>(back * 1000);
      const Stamp begin = clock.begin_of(sweep, skipped);
      EXPECT_NEAR(seconds(begin - (scip_epoch + span_from_seconds(t))), 0, 1.1e-3) << back << ", " << t;
      EXPECT_EQ(skipped, 0);
    }
    EXPECT_EQ(clock.steps(), 1U) << back;
  }
}

TEST(ScipTick, AnswersToSingleRequestsAreNoTurnsOfARow) {
  ScipClock clock(ClockMode::smooth, false);
  TickingSensor sensor;
  std::int64_t skipped = 7;
  for (double t = 0.0103; t < 3; t += 0.317) {
    ScipClock::Sweep sweep = sensor.sweep(t);
    sweep.evenly = false;
    const Stamp begin = clock.begin_of(sweep, skipped);
    EXPECT_EQ(skipped, 0);
    EXPECT_NEAR(seconds(begin - (scip_epoch + span_from_seconds(t))), 0, 1.1e-3);
  }
}

TEST(ScipTick, NeedsAComparisonWhenTheOneItHadIsLostOrTooOldToTellTheDelay) {
  TickingSensor sensor;
  ScipClock never(ClockMode::smooth, true);
  EXPECT_FALSE(never.needs_comparison()) << "none was ever made";
  ScipClock clock(ClockMode::smooth, true);
  clock.compare({1, false}, scip_epoch + 1ms, scip_epoch + 2ms);
  EXPECT_FALSE(clock.needs_comparison());
  // The two ways do not fit together: the comparison is lost.
  clock.compare({1, false}, scip_epoch + 100ms, scip_epoch + 101ms);
  EXPECT_TRUE(clock.needs_comparison());
  EXPECT_FALSE(clock.uncertainty());
  clock.connection();
  EXPECT_FALSE(clock.needs_comparison()) << "a new connection makes its own";
}

}  // namespace
}  // namespace lidard::test
