// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/device_clock.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <utility>

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

/// A packet every 10 ms of a device that keeps time; some packets come late.
struct Punctual {
  DeviceClock clock;
  int at = 0;  // ms
  void receive(int late_ms = 0) {
    at += 10;
    clock.observe(milliseconds(at), epoch + milliseconds(at + late_ms));
  }
  void receive_for(int ms, int late_ms = 0) {
    for (const int end = at + ms; at < end;) receive(late_ms);
  }
  Span error() const { return clock.to_host(milliseconds(at)) - (epoch + milliseconds(at)); }
};

TEST(DeviceClock, LatenessIsAStepOnceEveryPacketOfHalfASecondWasSoLate) {
  Punctual stall;
  stall.receive_for(3000);
  stall.receive_for(490, 200);
  EXPECT_EQ(stall.clock.steps(), 0U);
  EXPECT_LT(std::abs(stall.error().count()), 1'000'000);
  stall.receive_for(1000);
  EXPECT_EQ(stall.clock.steps(), 0U) << "it was a stall";
  Punctual step;
  step.receive_for(3000);
  step.receive_for(540, 200);
  EXPECT_EQ(step.clock.steps(), 1U);
  EXPECT_NEAR(lidard::seconds(step.error()), 0.2, 1e-3);
}

// A sender that stalls, and then sends what it has kept, is no recording without arrival times.
TEST(DeviceClock, TheBurstAfterALatenessThatBecameAStepIsNotPlacedAheadOfItsArrival) {
  for (const int late_ms : {200, 1400, 12'000}) {
    Punctual punctual;
    punctual.receive_for(3000);
    punctual.receive_for(540, late_ms);
    ASSERT_EQ(punctual.clock.steps(), 1U);
    for (int late = late_ms; late > 0; late -= 10) {
      punctual.receive(late);
      ASSERT_LE(lidard::seconds(punctual.error()), 1e-3 * late + 2e-3) << late << " of " << late_ms;
    }
    punctual.receive_for(1000);
    EXPECT_LT(std::abs(punctual.error().count()), 1'000'000) << late_ms;
    EXPECT_FALSE(punctual.clock.lacks_arrivals()) << late_ms;
  }
}

TEST(DeviceClock, ElevenSecondsLateIsAStepAtOnce) {
  Punctual stalled, stepped;
  stalled.receive_for(3000);
  stalled.receive(9000);
  EXPECT_EQ(stalled.clock.steps(), 0U);
  stepped.receive_for(3000);
  stepped.receive(11'000);
  EXPECT_EQ(stepped.clock.steps(), 1U);
  EXPECT_NEAR(lidard::seconds(stepped.error()), 11, 1e-6);
}

TEST(DeviceClock, StallsFarApartDoNotAddUpToAStep) {
  Punctual punctual;
  punctual.receive_for(3000);
  for (int stall = 0; stall < 6; ++stall) {
    punctual.receive_for(300, 200);
    punctual.receive_for(20);
  }
  EXPECT_EQ(punctual.clock.steps(), 0U);
  EXPECT_LT(std::abs(punctual.error().count()), 1'000'000);
}

TEST(DeviceClock, AStallBeforeAStepDoesNotHastenTheStep) {
  Punctual punctual;
  punctual.receive_for(3000);
  punctual.receive_for(300, 200);
  punctual.receive_for(3000);
  punctual.receive_for(400, 200);
  EXPECT_EQ(punctual.clock.steps(), 0U);
  punctual.receive_for(200, 200);
  EXPECT_EQ(punctual.clock.steps(), 1U);
  punctual.receive_for(400, 400);
  EXPECT_EQ(punctual.clock.steps(), 1U) << "what is late after a step is judged anew";
}

TEST(DeviceClock, FiftyMillisecondsLateIsJitterHoweverLongItLasts) {
  Punctual punctual;
  punctual.receive_for(3000);
  punctual.receive_for(2000, 48);
  EXPECT_EQ(punctual.clock.steps(), 0U);
  Punctual stepped;
  stepped.receive_for(3000);
  stepped.receive_for(2000, 53);
  EXPECT_EQ(stepped.clock.steps(), 1U);
}

TEST(DeviceClock, TooEarlyByMoreThanFiftyMillisecondsIsAStepAtOnceAndLessIsABetterEstimate) {
  Punctual better;
  better.receive_for(3000);
  better.receive(-48);
  EXPECT_EQ(better.clock.steps(), 0U);
  EXPECT_NEAR(lidard::seconds(better.error()), -0.048, 1e-3);
  Punctual stepped;
  stepped.receive_for(3000);
  stepped.receive(-53);
  EXPECT_EQ(stepped.clock.steps(), 1U);
  EXPECT_NEAR(lidard::seconds(stepped.error()), -0.053, 1e-6);
  EXPECT_FALSE(stepped.clock.knows_drift());
}

TEST(DeviceClock, InArrivalModeTenMillisecondsLateIsTheNetworkAndMoreAStalledHost) {
  for (const int late : {9, 11, 40}) {
    DeviceClock clock(ClockMode::arrival);
    for (int i = 1; i <= 400; ++i) clock.observe(milliseconds(10 * i), epoch + milliseconds(10 * i));
    clock.observe(milliseconds(4010), epoch + milliseconds(4010 + late));
    const Span error = clock.to_host(milliseconds(4010)) - (epoch + milliseconds(4010));
    EXPECT_NEAR(lidard::seconds(error), late < 10 ? late * 1e-3 : 0, 0.1e-3) << late;
  }
}

TEST(DeviceClock, KnowsTheDriftAfterFourHalfSecondsAndForgetsItOnReset) {
  Simulation sim{300, 0};
  DeviceClock clock;
  EXPECT_FALSE(clock.ready());
  EXPECT_EQ(clock.to_host(seconds(5)), Stamp{5'000'000'000}) << "nothing is known: device time it is";
  for (double t = 0; t < 10; t += 0.001) {
    clock.observe(sim.device(t), sim.arrival(t));
    if (t < 1.99) {
      ASSERT_FALSE(clock.knows_drift()) << t;
      ASSERT_EQ(clock.drift_ppm(), 0);
    }
    if (t > 2.02) {
      ASSERT_TRUE(clock.knows_drift()) << t;
      ASSERT_NEAR(clock.drift_ppm(), -300, 1) << t;
    }
  }
  EXPECT_GT(clock.spread(), Span(0));
  clock.reset();
  EXPECT_EQ(clock.spread(), Span(0));
  EXPECT_FALSE(clock.ready());
  EXPECT_FALSE(clock.knows_drift());
  EXPECT_EQ(clock.drift_ppm(), 0);
}

/// Largest errors, s: while a host's clock is slewed and for 12 s after, and from then on.
std::pair<double, double> errors_of_slew(double slew_ppm, double period, double jitter_s, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> delay(0, jitter_s);
  const auto host = [slew_ppm](double t) {
    return epoch + span_from_seconds(t + slew_ppm * 1e-6 * std::clamp(t - 20, 0.0, 10.0));
  };
  DeviceClock clock;
  std::pair<double, double> worst{0, 0};
  for (double t = 0; t < 60; t += period) {
    const Span device = span_from_seconds(t);
    clock.observe(device, host(t + delay(random)));
    const double error = std::abs(lidard::seconds(clock.to_host(device) - host(t)));
    if (t > 20 && t < 42) worst.first = std::max(worst.first, error);
    if (t > 42) worst.second = std::max(worst.second, error);
  }
  return worst;
}

// ntpd slews a host's clock by 500 ppm, chronyd by more. That rates have changed shows when no packet has
// come at the line for two seconds, in which the clocks drift apart by one ms.
TEST(DeviceClock, AHostThatIsSlewedBy500PpmIsFollowedWithinTwoMillisecondsAndQuietlyAfterwards) {
  for (const double ppm : {500.0, -500.0}) {
    for (const double period : {1 / 14.5, 0.025, 0.001327}) {
      for (const unsigned seed : {1U, 2U, 3U}) {
        const auto quiet = errors_of_slew(ppm, period, 0.3e-3, seed);
        EXPECT_LT(quiet.first, 2e-3) << ppm << " ppm, every " << period << " s";
        EXPECT_LT(quiet.second, 0.25e-3) << ppm << " ppm, every " << period << " s";
        const auto jittery = errors_of_slew(ppm, period, 5e-3, seed);
        EXPECT_LT(jittery.first, 3.5e-3) << ppm << " ppm, every " << period << " s";
        EXPECT_LT(jittery.second, 1e-3) << ppm << " ppm, every " << period << " s";
      }
    }
  }
}

TEST(DeviceClock, NoClockIsBelievedToDriftByMoreThanTwoPerMille) {
  Simulation sim{-5000, 0};
  DeviceClock clock;
  for (double t = 0; t < 6; t += 0.001) clock.observe(sim.device(t), sim.arrival(t));
  EXPECT_NEAR(clock.drift_ppm(), 2000, 1e-6);
  Simulation fast{5000, 0};
  DeviceClock other;
  for (double t = 0; t < 6; t += 0.001) other.observe(fast.device(t), fast.arrival(t));
  EXPECT_NEAR(other.drift_ppm(), -2000, 1e-6);
}

TEST(DeviceClock, PacketsInTheWrongOrderDoNoHarm) {
  Simulation sim{200, 0.05e-3};
  DeviceClock clock;
  for (int i = 0; i < 20000; ++i) {
    const int order = i % 8 == 3 ? i + 2 : i % 8 == 5 ? i - 2 : i;  // two of eight change places
    const double t = order * 0.001;
    clock.observe(sim.device(t), std::max(sim.arrival(t), epoch + span_from_seconds(i * 0.001)));
    if (i < 3000) continue;
    const double error = lidard::seconds(clock.to_host(sim.device(t)) - (epoch + span_from_seconds(t)));
    ASSERT_LT(std::abs(error), 0.2e-3) << i;
  }
  EXPECT_EQ(clock.steps(), 0U);
}

}  // namespace
}  // namespace lidard
