// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/device_clock.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

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

}  // namespace
}  // namespace lidard
