// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/host_clock.h"

#include <gtest/gtest.h>

#include <random>

namespace lidard {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

/// A host whose clock can be set.
struct Host {
  HostStamp realtime{1'700'000'000'000'000'000};
  Span monotonic = std::chrono::hours(5);

  void pass(Span time) {
    realtime = realtime + time;
    monotonic += time;
  }
  void set(Span step) { realtime = realtime + step; }
  ClockReading read() const { return {realtime, monotonic, microseconds(2)}; }
};

HostStamp host_of(const HostClock& clock, Stamp steady) { return ClockStep(clock.step()).host(steady); }

TEST(HostClock, IsTheHostsClockUntilThatIsSet) {
  Host host;
  HostClock clock(host.read());
  for (int i = 0; i < 1000; ++i) {
    host.pass(milliseconds(7));
    EXPECT_FALSE(clock.observe(host.read()));
    EXPECT_EQ(clock.steady(host.read()), Stamp{host.realtime.ns});
    EXPECT_EQ(clock.steady(host.realtime - milliseconds(3), host.read()),
              Stamp{host.realtime.ns} - milliseconds(3));
  }
  EXPECT_EQ(clock.steps(), 0U);
}

TEST(HostClock, GoesOnWhereTheHostsClockIsSetAndFindsBackToIt) {
  for (const double s : {0.002, 1.0, 1e8, -0.002, -1.0, -1e8}) {
    SCOPED_TRACE(s);
    Host host;
    HostClock clock(host.read());
    const Stamp before{host.realtime.ns};
    host.set(span_from_seconds(s));
    host.pass(milliseconds(10));
    EXPECT_EQ(clock.observe(host.read()), span_from_seconds(s));
    EXPECT_FALSE(clock.observe(host.read())) << "reported once";
    EXPECT_EQ(clock.steady(host.read()) - before, Span(milliseconds(10)));
    EXPECT_EQ(host_of(clock, clock.steady(host.read())), host.realtime);
    EXPECT_EQ(clock.steps(), 1U);
    EXPECT_EQ(clock.step(), span_from_seconds(s));
  }
}

TEST(HostClock, TakesNoSlowReadingForAStep) {
  Host host;
  HostClock clock(host.read());
  ClockReading slow = host.read();
  slow.realtime = slow.realtime + milliseconds(30);
  slow.uncertainty = milliseconds(30);
  EXPECT_FALSE(clock.observe(slow));
  slow.uncertainty = milliseconds(20);
  EXPECT_TRUE(clock.observe(slow));
}

TEST(HostClock, AddsSmallStepsUpUntilTheyCount) {
  Host host;
  HostClock clock(host.read());
  std::size_t steps = 0;
  for (int i = 0; i < 10; ++i) {
    host.set(microseconds(400));
    host.pass(milliseconds(10));
    steps += clock.observe(host.read()) ? 1U : 0U;
    EXPECT_LE(std::chrono::abs(host_of(clock, clock.steady(host.read())) - host.realtime),
              milliseconds(1) + microseconds(2));
  }
  EXPECT_EQ(steps, 3U);
}

TEST(HostClock, KnowsWhatWasStampedBeforeTheClockWasSet) {
  for (const double s : {0.05, 2.0, 1e8, -0.05, -2.0, -1e8}) {
    SCOPED_TRACE(s);
    Host host;
    HostClock clock(host.read());
    const HostStamp stamped_before = host.realtime;
    const Stamp true_time{host.realtime.ns};
    host.pass(milliseconds(3));
    host.set(span_from_seconds(s));
    const HostStamp stamped_after = host.realtime;
    host.pass(milliseconds(1));
    clock.observe(host.read());
    EXPECT_EQ(clock.steady(stamped_before, host.read()), true_time);
    EXPECT_EQ(clock.steady(stamped_after, host.read()), true_time + milliseconds(3));
  }
}

TEST(HostClock, ForgetsTheFormerTimeOnceNothingCanWaitAnyMore) {
  Host host;
  HostClock clock(host.read());
  host.set(milliseconds(2));
  clock.observe(host.read());
  host.pass(std::chrono::seconds(2));
  clock.observe(host.read());
  const HostStamp five_ms_ago = host.realtime - milliseconds(5);
  EXPECT_EQ(host.realtime - host_of(clock, clock.steady(five_ms_ago, host.read())), Span(milliseconds(5)));
}

TEST(HostClock, KeepsTheOrderAndTheTimeOfPacketsThroughAnySteps) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> seconds_of(-20, 20);
  for (int run = 0; run < 200; ++run) {
    Host host;
    HostClock clock(host.read());
    const Stamp begin{host.realtime.ns};
    const Span begin_monotonic = host.monotonic;
    for (int i = 0; i < 100; ++i) {
      // A packet comes, perhaps the clock is set, then the program looks.
      const HostStamp stamped = host.realtime;
      const Stamp truth = begin + (host.monotonic - begin_monotonic);
      host.pass(microseconds(random() % 5000));
      if (random() % 20 == 0) {
        double step = seconds_of(random);
        if (std::abs(step) < 0.02) step = 0.02;  // less than a packet waits cannot be distinguished
        host.set(span_from_seconds(step));
        host.pass(std::chrono::seconds(0));
      }
      clock.observe(host.read());
      ASSERT_EQ(clock.steady(stamped, host.read()), truth) << run << " " << i;
      host.pass(milliseconds(100));
      clock.observe(host.read());
      ASSERT_EQ(host_of(clock, clock.steady(host.read())), host.realtime);
    }
  }
}

}  // namespace
}  // namespace lidard
