// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/device_clock.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

namespace lidard {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr Stamp epoch{1'767'225'600'000'000'000};

/// Arrivals of a device whose clock runs `ppm` fast, one packet each 1.327 ms, exponential delays of mean
/// `jitter_s`.
struct Simulation {
  double ppm = 0;
  double jitter_s = 0;
  std::mt19937 random{7};

  Span device(double t) const { return span_from_seconds(t * (1 + ppm * 1e-6)); }
  Stamp arrival(double t) {
    const double u = static_cast<double>(random() >> 8U) / 16777216.0;
    return epoch + span_from_seconds(t - jitter_s * std::log(1 - u));
  }
};

TEST(DeviceClock, PlacesEachPacketByItsArrivalInArrivalMode) {
  DeviceClock clock(ClockMode::arrival);
  clock.observe(seconds(1), epoch + milliseconds(5));
  EXPECT_EQ(clock.to_host(seconds(1)), epoch + milliseconds(5));
  EXPECT_EQ(clock.to_host(seconds(1) - microseconds(3)), epoch + milliseconds(5) - microseconds(3));
  clock.observe(seconds(2), epoch + milliseconds(1009));
  EXPECT_EQ(clock.to_host(seconds(2)), epoch + milliseconds(1009));
}

TEST(DeviceClock, RemovesJitterAndFollowsDrift) {
  for (const double ppm : {-200.0, 0.0, 100.0}) {
    Simulation sim{ppm, 1e-3};
    DeviceClock clock;
    double square_sum = 0, worst = 0;
    int n = 0;
    for (double t = 0; t < 30; t += 0.001327) {
      clock.observe(sim.device(t), sim.arrival(t));
      if (t < 5) continue;
      const double error = lidard::seconds(clock.to_host(sim.device(t)) - (epoch + span_from_seconds(t)));
      square_sum += error * error;
      worst = std::max(worst, std::abs(error));
      ++n;
    }
    EXPECT_LT(std::sqrt(square_sum / n), 0.1e-3) << ppm;
    EXPECT_LT(worst, 0.3e-3) << ppm;
    EXPECT_EQ(clock.steps(), 0U);
  }
}

TEST(DeviceClock, RecoversFromAStepOfEitherClockWithinASecond) {
  for (const double step_s : {-3600.0, -1.0, 1.0, 1e6}) {
    Simulation sim{50, 0.5e-3};
    DeviceClock clock;
    for (double t = 0; t < 12; t += 0.001327) {
      const double shift = t < 6 ? 0 : step_s;
      clock.observe(sim.device(t), sim.arrival(t) + span_from_seconds(shift));
      if (t < 5 || (t > 6 && t < 7)) continue;
      const Stamp truth = epoch + span_from_seconds(t + shift);
      ASSERT_LT(std::abs(lidard::seconds(clock.to_host(sim.device(t)) - truth)), 2e-3)
          << step_s << " at " << t;
    }
    EXPECT_EQ(clock.steps(), 1U);
  }
}

TEST(DeviceClock, ShortStallDoesNotMoveTheEstimate) {
  Simulation sim{0, 0.1e-3};
  DeviceClock clock;
  for (double t = 0; t < 8; t += 0.001327) {
    const Stamp arrival = t > 6 && t < 6.3 ? epoch + span_from_seconds(6.3) : sim.arrival(t);
    clock.observe(sim.device(t), arrival);
    if (t > 3) {
      const Span error = clock.to_host(sim.device(t)) - (epoch + span_from_seconds(t));
      ASSERT_LT(std::abs(lidard::seconds(error)), 0.2e-3) << t;
    }
  }
  EXPECT_EQ(clock.steps(), 0U);
}

TEST(DeviceClock, NeverPlacesAPacketAfterItsArrival) {
  Simulation sim{150, 2e-3};
  DeviceClock clock;
  for (double t = 0; t < 20; t += 0.001327) {
    const Stamp arrival = sim.arrival(t);
    clock.observe(sim.device(t), arrival);
    ASSERT_LE(clock.to_host(sim.device(t)).ns, arrival.ns + 20'000) << t;
  }
}

/// A device that sends every `period_s` with a counter of whole `tick_s`, over a network that adds up to
/// `jitter_s`.
struct Device {
  double ppm, period_s, tick_s, jitter_s;
};

double worst_error(const Device& device, double from_s, double to_s, const std::string& what) {
  std::mt19937 random(11);
  DeviceClock clock;
  double worst = 0;
  for (double t = 0.123; t < to_s; t += device.period_s) {
    const double shown = std::floor(t * (1 + device.ppm * 1e-6) / device.tick_s + 1e-9) * device.tick_s;
    const double late = device.jitter_s * static_cast<double>(random() >> 8U) / 16777216.0;
    const Span read = span_from_seconds(shown);
    clock.observe(read, epoch + span_from_seconds(t + late));
    if (t < from_s) continue;
    // What the counter does not show is its own: a stamp may be early by it.
    const double error = lidard::seconds(clock.to_host(read) - (epoch + span_from_seconds(t)));
    worst = std::max(worst, error > 0 ? error : std::max(0.0, -error - device.tick_s));
  }
  EXPECT_EQ(clock.steps(), 0U) << what;
  return worst;
}

TEST(DeviceClock, HoldsHalfAMillisecondUpToAThousandPpm) {
  for (double ppm = -1000; ppm <= 1000; ppm += 250) {
    for (const double period_s : {0.001327, 0.0251, 0.0999}) {
      for (const double tick_s : {1e-6, 1e-3}) {
        for (const double jitter_s : {0.0, 0.2e-3}) {
          const std::string what = std::to_string(ppm) + " ppm, every " + std::to_string(period_s) +
                                   " s, ticks of " + std::to_string(tick_s) + ", jitter " +
                                   std::to_string(jitter_s);
          const Device device{ppm, period_s, tick_s, jitter_s};
          EXPECT_LT(worst_error(device, 3, 40, what), 0.5e-3) << what;
          EXPECT_LT(worst_error(device, 0, 3, what), 1e-3) << what << ", from the first packet on";
        }
      }
    }
  }
}

TEST(DeviceClock, StallsOfTheHostMoveTheEstimateLittleAtAnyDrift) {
  for (const double ppm : {-1000.0, 0.0, 1000.0}) {
    for (const double stall_s : {0.03, 0.3, 2.0}) {
      Simulation sim{ppm, 0.1e-3};
      DeviceClock clock;
      double worst = 0;
      for (double t = 0; t < 30; t += 0.001327) {
        // One stall every 5 s; what came meanwhile is taken at its end.
        const double phase = std::fmod(t, 5);
        const Stamp arrival = phase > 4 && phase < 4 + stall_s
                                  ? epoch + span_from_seconds(t - phase + 4 + stall_s)
                                  : sim.arrival(t);
        clock.observe(sim.device(t), std::max(arrival, epoch + span_from_seconds(t)));
        if (t < 3) continue;
        const double error = lidard::seconds(clock.to_host(sim.device(t)) - (epoch + span_from_seconds(t)));
        worst = std::max(worst, std::abs(error));
      }
      EXPECT_LT(worst, 0.5e-3) << ppm << " ppm, stalls of " << stall_s << " s";
      EXPECT_EQ(clock.steps(), 0U);
    }
  }
}

TEST(DeviceClock, InArrivalModeAStallOfTheHostDoesNotGoIntoTheStamps) {
  Simulation sim{-500, 0.2e-3};
  DeviceClock clock(ClockMode::arrival);
  for (double t = 0; t < 12; t += 0.001327) {
    const double phase = std::fmod(t, 3);
    const bool stalled = phase > 2 && phase < 2.4;
    const Stamp arrival = stalled ? epoch + span_from_seconds(t - phase + 2.4) : sim.arrival(t);
    clock.observe(sim.device(t), arrival);
    const Span error = clock.to_host(sim.device(t)) - (epoch + span_from_seconds(t));
    const double allowed = stalled ? 10.5e-3 : 5e-3;
    ASSERT_LT(std::abs(lidard::seconds(error)), allowed) << t;
    if (!stalled) {
      ASSERT_EQ(clock.to_host(sim.device(t)), arrival) << "the rest is placed by its own arrival";
    }
  }
}

}  // namespace
}  // namespace lidard
