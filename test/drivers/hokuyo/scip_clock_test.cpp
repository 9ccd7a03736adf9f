// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/hokuyo/scip_clock.h"

#include <array>
#include <cmath>

#include "test/drivers/hokuyo/scip_bench.h"

namespace lidard::test {
namespace {

using namespace std::chrono_literals;
using sim::ScipDeviceOptions;

struct Errors {
  double p99 = 0, worst = 0, mean = 0;  ///< s
};

/// Of the stamps of all scans but those of the first `from` seconds; also tests their order.
Errors errors(const ScipBench& bench, double from) {
  std::vector<double> all;
  double sum = 0;
  for (std::size_t i = 0; i < bench.scans.size(); ++i) {
    if (i > 0) {
      EXPECT_GT(bench.scans[i].stamp, bench.scans[i - 1].stamp);
    }
    EXPECT_LE(bench.scans[i].stamp, bench.arrivals[i]);
    if (seconds(bench.arrivals[i] - scip_epoch) < from) continue;
    const double error = seconds(bench.scans[i].stamp - bench.sweeps[i]);
    sum += error;
    all.push_back(std::abs(error));
  }
  std::sort(all.begin(), all.end());
  if (all.empty()) return {1, 1, 1};
  return {all[all.size() * 99 / 100], all.back(), sum / static_cast<double>(all.size())};
}

ScipDeviceOptions jittery(double clock_ppm, double motor_ppm) {
  ScipDeviceOptions options;
  options.clock_ppm = clock_ppm;
  options.motor_ppm = motor_ppm;
  options.counter = 123'456;
  options.transit.jitter = 300us;
  return options;
}

// The motor's speed decides what whole milliseconds show: the crystal's own (none of the phase), a bit off
// (a slow beat), far off (a fast one).
TEST(ScipClock, StampsAreWithinHalfAMillisecondAfterTenSeconds) {
  for (const double clock_ppm : {100.0, -100.0, 0.0}) {
    for (const double motor_ppm : {0.0, 37.0, 700.0, 8000.0}) {
      for (const bool compare : {true, false}) {
        DriverConfig config;
        config.requests.calibrate_time = compare;
        ScipBench bench(jittery(clock_ppm, motor_ppm), config, "hokuyo_scip");
        bench.run(30s);
        const Errors e = errors(bench, 10);
        EXPECT_LT(e.p99, 0.5e-3) << clock_ppm << " ppm, motor " << motor_ppm << " ppm, TM " << compare;
        std::printf("clock %5.0f ppm, motor %6.0f ppm, TM %d: p99 %.3f ms, worst %.3f ms, mean %+.3f ms\n",
                    clock_ppm, motor_ppm, compare, e.p99 * 1e3, e.worst * 1e3, e.mean * 1e3);
        EXPECT_EQ(bench.driver->counters().lost_packets, 0U);
        EXPECT_EQ(bench.driver->counters().clock_steps, 0U);
      }
    }
  }
}

TEST(ScipClock, HoldsUpToAThousandPpmWithEveryKindOfStamp) {
  for (const double clock_ppm : {-1000.0, -500.0, -100.0, 300.0, 1000.0}) {
    for (const bool percent : {false, true}) {
      for (const double motor_ppm : {0.0, 2000.0}) {
        ScipDeviceOptions options = jittery(clock_ppm, motor_ppm);
        options.processing = 3ms;
        options.knows_percent = percent;
        if (percent) options.firmware = "4.1.0";
        ScipBench bench(options, {}, percent ? "hokuyo_ust_10lx" : "hokuyo_scip");
        bench.run(25s);
        const Errors settled = errors(bench, 5), begin = errors(bench, 0.5);
        // Where whole ms beat slowly with the motor, a part of one stays hidden.
        const double allowed = percent ? 0.5e-3 : 0.6e-3;
        EXPECT_LT(settled.worst, allowed) << clock_ppm << " ppm, motor " << motor_ppm << ", % " << percent;
        EXPECT_LT(begin.worst, percent ? 1e-3 : 1.5e-3)
            << clock_ppm << " ppm, motor " << motor_ppm << ", % " << percent;
        std::printf("clock %6.0f ppm, motor %5.0f ppm, %% %d: p99 %.3f, worst %.3f, from 0.5 s on %.3f ms\n",
                    clock_ppm, motor_ppm, percent, settled.p99 * 1e3, settled.worst * 1e3, begin.worst * 1e3);
        EXPECT_EQ(bench.driver->counters().clock_steps, 0U);
        EXPECT_EQ(bench.driver->counters().lost_packets, 0U);
      }
    }
  }
}

TEST(ScipClock, AHostThatDoesNotLookForAWhileDoesNotMoveTheStamps) {
  for (const double clock_ppm : {-1000.0, 0.0, 1000.0}) {
    for (const double stall_s : {0.03, 0.4, 1.7}) {
      hokuyo::ScipClock clock(ClockMode::smooth, false);
      double worst = 0;
      std::int64_t skipped = 0;
      for (double t = 0.0101; t < 60; t += 0.02505) {
        const double phase = std::fmod(t, 7);
        const double sent = t + 0.018;
        const double taken = phase > 5 && phase < 5 + stall_s ? t - phase + 5 + stall_s + 0.018 : sent;
        hokuyo::ScipClock::Sweep sweep;
        sweep.stamp = {static_cast<std::uint64_t>(t * (1 + clock_ppm * 1e-6) * 1000), false};
        sweep.period = 25ms;
        sweep.until_sent = 18ms;
        sweep.arrival = scip_epoch + span_from_seconds(taken);
        const Stamp begin = clock.begin_of(sweep, skipped);
        if (t > 5) worst = std::max(worst, std::abs(seconds(begin - (scip_epoch + span_from_seconds(t)))));
        EXPECT_EQ(skipped, 0);
      }
      EXPECT_LT(worst, 0.5e-3) << clock_ppm << " ppm, stalls of " << stall_s << " s";
      EXPECT_EQ(clock.steps(), 0U) << clock_ppm << " ppm, stalls of " << stall_s << " s";
    }
  }
}

TEST(ScipClock, TheFirstScansAreRightThoughTheyWereTakenLate) {
  for (const bool percent : {false, true}) {
    hokuyo::ScipClock clock(ClockMode::smooth, false);
    const auto shown = [&](double t) {
      return hokuyo::ScipStamp{static_cast<std::uint64_t>(t * (percent ? 1e6 : 1e3)), percent};
    };
    const auto at = [](double t) { return scip_epoch + span_from_seconds(t); };
    for (double t = 0.0103; t < 0.03; t += 0.0017) clock.compare(shown(t), at(t - 0.0001), at(t + 0.0001));
    std::int64_t skipped = 0;
    for (double t = 0.1; t < 1; t += 0.02505) {
      hokuyo::ScipClock::Sweep sweep;
      sweep.stamp = shown(t);
      sweep.period = 25ms;
      sweep.until_sent = 18ms;
      sweep.arrival = at(t + 0.018 + (t < 0.4 ? 0.015 : 0));
      const Stamp begin = clock.begin_of(sweep, skipped);
      EXPECT_LT(std::abs(seconds(begin - at(t))), percent ? 1e-3 : 1.5e-3) << t;
    }
  }
}

// One scan of ten: at 4 Hz the comparison must not be forgotten before the delay is known.
TEST(ScipClock, AComparisonServesASlowStreamToo) {
  for (const double clock_ppm : {-1000.0, 1000.0}) {
    ScipDeviceOptions options = jittery(clock_ppm, 0);
    options.processing = 7ms;
    DriverConfig config;
    config.requests.skip = 9;
    ScipBench bench(options, config);
    bench.run(60s);
    EXPECT_LT(errors(bench, 15).worst, 1e-3) << clock_ppm;
    EXPECT_EQ(bench.written.find("TM0"), bench.written.rfind("TM0")) << "one comparison was enough";
  }
}

TEST(ScipClock, AComparisonThatWasLostIsMadeAgain) {
  ScipDeviceOptions options = jittery(100, 700);
  options.processing = 7ms;
  ScipBench bench(options);
  bench.run(200ms);
  EXPECT_EQ(bench.written.find("TM0"), bench.written.rfind("TM0"));
  // The sensor sets its counter anew right after the comparison: what it said is worth nothing.
  bench.sensor.options().counter += 3'600'000'000;
  bench.run(30s);
  EXPECT_NE(bench.written.find("TM0"), bench.written.rfind("TM0"));
  EXPECT_EQ(bench.driver->counters().clock_steps, 1U);
  EXPECT_LT(errors(bench, 10).p99, 0.5e-3);
  EXPECT_LT(bench.driver->counters().lost_packets, 20U) << "a further comparison costs some scans, once";
}

// Such a sensor hides the fraction of a ms; what is left of it depends on the beat with the motor.
TEST(ScipClock, StampsOfASensorThatSendsOnItsTickAreWithinLittleMoreThanOneOfThem) {
  for (const double clock_ppm : {-1000.0, 100.0, 1000.0}) {
    for (const double motor_ppm : {0.0, 37.0, 700.0, 2000.0, -3000.0}) {
      ScipDeviceOptions options = jittery(clock_ppm, motor_ppm);
      ScipBench bench(options);
      bench.run(30s);
      const Errors e = errors(bench, 10);
      EXPECT_LT(e.p99, 1.3e-3) << clock_ppm << " ppm, motor " << motor_ppm << " ppm";
      std::printf("on its tick, clock %6.0f, motor %6.0f ppm: p99 %.3f ms, worst %.3f ms, mean %+.3f ms\n",
                  clock_ppm, motor_ppm, e.p99 * 1e3, e.worst * 1e3, e.mean * 1e3);
    }
  }
}

/// A sensor as seqsense/urg_stamped describes it, README and src/urg_sim/urg_sim.cpp, and its way to the
/// host. Scans that leave at once are those of that simulator's UST, whose waitTick() never waits.
struct TimedSensor {
  const char* name;
  const char* model;
  bool on_tick;      ///< scans leave with the next ms
  int time_tick_ms;  ///< of answers to TM1; 0: at once
  Span way, jitter;
  Span host_late{0};  ///< up to so long the host reads after an arrival
};
constexpr TimedSensor timed_sensors[] = {
    {"UST, at once", "hokuyo_ust_10lx", false, 0, 400us, 100us},
    {"UST, on 1 ms", "hokuyo_ust_10lx", true, 0, 400us, 100us},
    {"UST, TM1 on 5 ms", "hokuyo_ust_10lx", true, 5, 100us, 50us},
    {"UTM", "hokuyo_utm_30lx_ew", false, 0, 500us, 640us},
    {"UTM, busy host", "hokuyo_utm_30lx_ew", false, 0, 200us, 100us, 8ms}};

/// Mean errors of the stamps of a run, s: of the first second, from 1 to 5 s, to 10 s, and later.
std::array<double, 4> biases(const TimedSensor& kind, double clock_ppm, double motor_ppm, unsigned seed) {
  ScipDeviceOptions options;
  options.clock_ppm = clock_ppm;
  options.motor_ppm = motor_ppm;
  options.processing = 0us;
  options.time_tick_ms = kind.time_tick_ms;
  options.counter = 123'456 + 337 * seed;
  options.transit = {kind.way, kind.jitter, seed};
  ScipBench bench(options, {}, kind.model);
  bench.sensor.options().sends_on_tick = kind.on_tick;
  bench.rng = sim::Rng(100 + seed);
  bench.way_up = kind.way;
  bench.way_up_jitter = kind.jitter;
  bench.host_late = kind.host_late;
  bench.run(25s);
  std::array<double, 4> sum{};
  std::array<double, 4> scans{};
  for (std::size_t i = 0; i < bench.scans.size(); ++i) {
    const double t = seconds(bench.arrivals[i] - scip_epoch);
    const std::size_t part = t < 1 ? 0 : t < 5 ? 1 : t < 10 ? 2 : 3;
    sum[part] += seconds(bench.scans[i].stamp - bench.sweeps[i]);
    ++scans[part];
  }
  for (std::size_t part = 0; part < sum.size(); ++part) sum[part] /= scans[part];
  return sum;
}

// A motor in step with the counter hides the phase: see HoldsUpToAThousandPpmWithEveryKindOfStamp.
TEST(ScipClock, WhateverASensorWaitsForItsStampsHaveLittleBias) {
  for (const TimedSensor& kind : timed_sensors) {
    for (const double clock_ppm : {-1000.0, 50.0, 1000.0}) {
      std::array<double, 4> worst{};
      for (unsigned seed = 1; seed <= 5; ++seed) {
        const auto bias = biases(kind, clock_ppm, 2000, seed);
        for (std::size_t part = 0; part < bias.size(); ++part) {
          if (std::abs(bias[part]) > std::abs(worst[part])) worst[part] = bias[part];
        }
      }
      std::printf("%-16s %5.0f ppm: worst bias %+.3f, from 1 s %+.3f, from 5 s %+.3f, from 10 s %+.3f ms\n",
                  kind.name, clock_ppm, worst[0] * 1e3, worst[1] * 1e3, worst[2] * 1e3, worst[3] * 1e3);
      EXPECT_LT(std::abs(worst[1]), 0.5e-3) << kind.name << ", " << clock_ppm << " ppm";
      EXPECT_LT(std::abs(worst[2]), 0.3e-3) << kind.name << ", " << clock_ppm << " ppm";
      EXPECT_LT(std::abs(worst[3]), 0.3e-3) << kind.name << ", " << clock_ppm << " ppm";
    }
  }
}

TEST(ScipClock, ARecordingOfAConnectionGivesTheStampsOfTheLiveRun) {
  for (const bool percent : {false, true}) {
    ScipDeviceOptions options = jittery(100, 700);
    options.processing = 7ms;
    options.knows_percent = percent;
    if (percent) options.firmware = "4.1.0";
    ScipBench live(options);
    live.recording = true;
    live.run(3s);
    ScipBench replay;
    for (const auto& [arrival, bytes] : live.recorded) {
      replay.now = arrival;
      replay.feed(bytes, arrival == live.recorded[0].first);
    }
    ASSERT_EQ(replay.scans.size(), live.scans.size());
    for (std::size_t i = 0; i < live.scans.size(); ++i)
      ASSERT_EQ((replay.scans[i].stamp - live.scans[i].stamp).count(), 0)
          << "scan " << i << ", % " << percent;
  }
}

TEST(ScipClock, AComparisonShowsWhatTheSensorTakesToSend) {
  ScipDeviceOptions options = jittery(20, 700);
  options.processing = 7ms;
  ScipBench with(options);
  with.run(30s);
  DriverConfig passive;
  passive.requests.calibrate_time = false;
  ScipBench without(options, passive);
  without.run(30s);
  EXPECT_LT(errors(with, 10).p99, 0.5e-3);
  EXPECT_NEAR(errors(without, 10).mean, 7e-3, 0.6e-3) << "by listening alone it cannot be known";
  EXPECT_NE(with.detail("Computed Latency"), "(missing)");
}

TEST(ScipClock, LostScansAreCountedByTheirTime) {
  ScipBench bench;
  bench.run(2s);
  bench.muted = true;
  bench.run(100ms);
  bench.muted = false;
  bench.run(1s);
  EXPECT_EQ(bench.driver->counters().lost_packets, 4U);
}

TEST(ScipClock, UnsmoothedEveryScanIsPlacedByItsOwnArrival) {
  DriverConfig config;
  config.clock = ClockMode::arrival;
  ScipBench bench(jittery(100, 0), config);
  bench.run(5s);
  for (std::size_t i = 0; i < bench.scans.size(); ++i)
    EXPECT_NEAR(seconds(bench.arrivals[i] - bench.scans[i].stamp), 0.01875, 1e-6);
}

}  // namespace
}  // namespace lidard::test
