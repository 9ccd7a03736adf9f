// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "drivers/sick/cola/cola_scan.h"
#include "drivers/sick/safety/scan_clock.h"

namespace lidard::sick {
namespace {

constexpr Stamp epoch{1'767'225'600'000'000'000};

/// Arrivals at a host that now and then does not look for a while, on a clock of their own.
class Host {
 public:
  Host(double jitter_s, double stall_s) : jitter_s_(jitter_s), stall_s_(stall_s) {}
  /// What was sent at `t` s is taken then.
  Stamp takes(double t) {
    const double phase = std::fmod(t, 7);
    const double ready = phase > 5 && phase < 5 + stall_s_ ? t - phase + 5 + stall_s_ : t;
    const double late = jitter_s_ * static_cast<double>(random_() >> 8U) / 16777216.0;
    last_ = std::max(last_, ready + late);
    return epoch + span_from_seconds(last_);
  }

 private:
  double jitter_s_, stall_s_, last_ = 0;
  std::mt19937 random_{3};
};

std::string words(double ppm, double stall_s) {
  return std::to_string(ppm) + " ppm, stalls of " + std::to_string(stall_s) + " s";
}

double error_s(Stamp stamp, double truth_s) {
  return std::abs(seconds(stamp - (epoch + span_from_seconds(truth_s))));
}

TEST(ColaClock, HoldsHalfAMillisecondUpToAThousandPpmWhateverTheHostDoes) {
  for (double ppm = -1000; ppm <= 1000; ppm += 250) {
    for (const double stall_s : {0.0, 0.04, 0.4, 1.7}) {
      ColaClock clock(ClockMode::smooth);
      Host host(0.2e-3, stall_s);
      double worst = 0, first = 0;
      // The counter of microseconds overflows on the way.
      for (double t = 0.01; t < 60; t += 0.0667) {
        const double device_us = 4'290'000'000.0 + t * (1e6 + ppm);
        const auto start = static_cast<std::uint32_t>(static_cast<std::uint64_t>(device_us));
        const double sent = t + 0.0063;
        const Span begin =
            clock.observe(start, start + 6300, Span(50'000'000), Span(66'666'667), host.takes(sent));
        double& into = t < 3 ? first : worst;
        into = std::max(into, error_s(clock.to_host(begin), t));
      }
      EXPECT_LT(worst, 0.5e-3) << words(ppm, stall_s);
      EXPECT_LT(first, 1e-3) << words(ppm, stall_s);
      EXPECT_EQ(clock.steps(), 0U) << words(ppm, stall_s);
    }
  }
}

// Datagrams bear the kernel's time of arrival: no host stalls them. The turn of the mirror is its clock.
TEST(ScanClock, HoldsHalfAMillisecondUpToAThousandPpm) {
  for (double ppm = -1000; ppm <= 1000; ppm += 250) {
    for (const double jitter_s : {0.0, 0.2e-3}) {
      ScanClock clock(ClockMode::smooth);
      Host host(jitter_s, 0);
      constexpr Span scan_time{30'000'000};
      double worst = 0, first = 0;
      std::uint32_t number = 0xffffff00;
      for (double t = 0.01; t < 60; t += 0.03 / (1 + ppm * 1e-6)) {
        const Stamp end = clock.end_of_scan(++number, scan_time, host.takes(t));
        double& into = t < 3 ? first : worst;
        into = std::max(into, error_s(end, t));
      }
      EXPECT_LT(worst, 0.5e-3) << words(ppm, 0);
      EXPECT_LT(first, 1e-3) << words(ppm, 0);
      EXPECT_EQ(clock.steps(), 0U) << words(ppm, 0);
    }
  }
}

TEST(ScanClock, ScansThatASwitchKeptForAWhileAreNotPlacedAheadOfTheirArrival) {
  for (const double stall_s : {0.4, 0.6, 1.45, 9.0}) {
    ScanClock clock(ClockMode::smooth);
    Host host(0.1e-3, 0);
    constexpr double scan_s = 0.03;
    for (int number = 0; number < 1000; ++number) {
      const double measured = 0.01 + scan_s * number;
      const bool kept = measured > 10 && measured < 10 + stall_s;
      const Stamp arrival = host.takes(kept ? 10 + stall_s + 1e-4 * (measured - 10) : measured);
      const Stamp end =
          clock.end_of_scan(static_cast<std::uint32_t>(number), span_from_seconds(scan_s), arrival);
      ASSERT_LT(seconds(end - arrival), 1e-3) << "scan " << number << ", stall of " << stall_s << " s";
      if (measured > 5) {
        ASSERT_LT(error_s(end, measured), 1e-3) << "scan " << number << ", stall of " << stall_s << " s";
      }
    }
  }
}

}  // namespace
}  // namespace lidard::sick
