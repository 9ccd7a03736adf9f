// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <limits>

#include "test/core/merge/scheduler_bench.h"

namespace lidard {
namespace {

using test::FreeScanner;
using test::origin;
using test::Schedule;

TEST(SchedulerEvents, WhoAsksAtTheEventsAloneMissesNothingThatWhoAlwaysAsksGets) {
  sim::Rng rng(3);
  std::size_t compared = 0;
  for (const Policy policy : {Policy::complete, Policy::rate, Policy::trigger}) {
    for (int round = 0; round < 24; ++round) {
      ScheduleSettings settings;
      settings.policy = policy;
      settings.rate = 5 + 20 * rng.uniform();
      if (round % 3 == 1) settings.lost_after = ms(30 + 100 * rng.uniform());
      if (round % 4 == 1) settings.deadline = ms(30 * rng.uniform());
      const std::size_t sources = 1 + static_cast<std::size_t>(round) % 3;
      settings.trigger = sources - 1;
      // A day in the life of some scanners: some late, some silent for a while, some from the start.
      std::vector<FreeScanner> scanners(sources);
      for (FreeScanner& scanner : scanners) {
        scanner.period = 20 + 60 * rng.uniform();
        scanner.phase = scanner.period * rng.uniform();
        scanner.silent_from = rng.uniform() * 2500;
        scanner.back = scanner.silent_from + rng.uniform() * 1500;
        scanner.delay = 10 * rng.uniform();
        scanner.delay_jitter = 3;
      }
      const auto events = Schedule(scanners, 4000, settings).outputs;
      const auto always = Schedule(scanners, 4000, settings, true).outputs;
      ASSERT_EQ(events.size(), always.size()) << to_string(policy) << ' ' << round;
      for (std::size_t i = 0; i < events.size(); ++i) {
        ASSERT_EQ(events[i].at, always[i].at)
            << to_string(policy) << ' ' << round << ' ' << seconds(always[i].at);
        ASSERT_EQ(events[i].use, always[i].use) << seconds(events[i].at);
      }
      compared += events.size();
    }
  }
  EXPECT_GT(compared, 3000U);
}

TEST(SchedulerEvents, AnEventLiesInTheFutureAndThereIsNoneOnceEverythingIsLost) {
  Scheduler scheduler(2, {});
  scheduler.delivered(0, origin, 0.05, origin);
  scheduler.delivered(1, origin + ms(7), 0.08, origin + ms(9));
  Stamp now = origin + ms(9);
  int events = 0;
  while (const auto event = scheduler.next_event()) {
    ASSERT_GT(*event, now);
    now = *event;
    scheduler.is_due(now);
    ASSERT_LT(++events, 20);
  }
  EXPECT_EQ(scheduler.state(0, now), SourceState::lost);
  EXPECT_EQ(scheduler.state(1, now), SourceState::lost);
}

/// One source whose sweeps end and arrive after so many ms each.
struct OneSource {
  Scheduler scheduler{1, {}};
  Span at{};
  void deliver(double after_ms, double told_s = 0) {
    at += ms(after_ms);
    scheduler.delivered(0, origin + at, told_s, origin + at);
  }
  double period_ms() const { return scheduler.period(0) * 1000; }
};

TEST(SchedulerPeriod, PausesThatAreNotInARowAreNoSlowerPeriod) {
  OneSource source;
  for (int i = 0; i < 10; ++i) source.deliver(50, 0.05);
  for (int i = 0; i < 12; ++i) {
    source.deliver(200);
    source.deliver(200);
    source.deliver(50);
    ASSERT_NEAR(source.period_ms(), 50, 1e-6) << i;
  }
  source.deliver(200);
  source.deliver(200);
  ASSERT_NEAR(source.period_ms(), 50, 1e-6);
  source.deliver(200);
  EXPECT_NEAR(source.period_ms(), 200, 1e-6) << "the third in a row is believed";
}

TEST(SchedulerPeriod, LessThanOneAndAHalfPeriodsAreNoPause) {
  OneSource source;
  source.deliver(0, 0.04);
  source.deliver(59);
  EXPECT_GT(source.period_ms(), 40.1);
  OneSource other;
  other.deliver(0, 0.04);
  other.deliver(61);
  EXPECT_NEAR(other.period_ms(), 40, 1e-9);
}

TEST(SchedulerPeriod, FollowsADeviceThatTurnsALittleFasterOrSlower) {
  for (const double now : {45.0, 58.0}) {
    OneSource source;
    for (int i = 0; i < 10; ++i) source.deliver(50, 0.05);
    for (int i = 0; i < 30; ++i) source.deliver(now);
    EXPECT_NEAR(source.period_ms(), now, 0.05);
  }
}

TEST(SchedulerPeriod, AConfiguredPeriodCountsUntilOneIsMeasuredAndNonsenseNever) {
  for (const double nonsense :
       {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    OneSource source;
    source.deliver(0, nonsense);
    EXPECT_EQ(source.period_ms(), 0) << nonsense;
    source.deliver(70, nonsense);
    EXPECT_NEAR(source.period_ms(), 70, 1e-9);
  }
  OneSource source;
  source.deliver(0, 0.05);
  EXPECT_NEAR(source.period_ms(), 50, 1e-9);
  source.scheduler.delivered(0, origin, 0, origin + ms(1));  // a sweep that ends when the last one did
  EXPECT_NEAR(source.period_ms(), 50, 1e-9);
}

TEST(SchedulerLimits, ASourceIsWaitedForByThreeTenthsOfTheShortestPeriod) {
  Scheduler scheduler(3, {});
  EXPECT_EQ(scheduler.deadline(), ms(30)) << "of 10 Hz, until a period is known";
  scheduler.delivered(0, origin, 0.08, origin);
  EXPECT_EQ(scheduler.deadline(), ms(24));
  scheduler.delivered(1, origin, 0.02, origin);
  scheduler.delivered(2, origin, 0.05, origin);
  EXPECT_EQ(scheduler.deadline(), ms(6));
  EXPECT_EQ(scheduler.state(0, origin + ms(86)), SourceState::ok);
  EXPECT_EQ(scheduler.state(0, origin + ms(86) + Span(1)), SourceState::stale);
  ScheduleSettings settings;
  settings.deadline = ms(1);
  Scheduler strict(1, settings);
  strict.delivered(0, origin, 0.05, origin);
  EXPECT_EQ(strict.state(0, origin + ms(51)), SourceState::ok);
  EXPECT_EQ(strict.state(0, origin + ms(51) + Span(1)), SourceState::stale);
}

TEST(SchedulerLimits, TheUsualDelayOfASourceIsWaitedForButNotMoreThanItsPeriod) {
  for (const double delay : {0.0, 10.0, 39.0, 41.0, 90.0}) {
    ScheduleSettings settings;
    settings.deadline = ms(5);
    Scheduler scheduler(1, settings);
    for (int i = 0; i < 50; ++i)
      scheduler.delivered(0, origin + ms(40 * i), 0.04, origin + ms(40 * i + delay));
    const Stamp end = origin + ms(40 * 49);
    const Stamp overdue = end + ms(40 + std::min(delay, 40.0) + 5);
    if (overdue > end + ms(delay)) {
      EXPECT_EQ(scheduler.state(0, overdue - ms(0.001)), SourceState::ok) << delay;
    }
    EXPECT_EQ(scheduler.state(0, std::max(overdue, end + ms(delay)) + ms(0.001)), SourceState::stale)
        << delay;
    EXPECT_EQ(scheduler.age(0, end + ms(123)), ms(123));
  }
}

TEST(SchedulerLimits, ASourceThatDiesAfterItsStampsJumpedAheadIsOverdueAndLostAsAnyOther) {
  Scheduler scheduler(1, {});
  for (double at = 0; at <= 1000; at += 25) {
    const double ahead = at >= 950 ? 10'000 : 0;
    scheduler.delivered(0, origin + ms(at + ahead), 0.025, origin + ms(at));
  }
  EXPECT_EQ(scheduler.state(0, origin + ms(1025)), SourceState::ok);
  EXPECT_EQ(scheduler.state(0, origin + ms(1060)), SourceState::stale);
  EXPECT_EQ(scheduler.state(0, origin + ms(1410)), SourceState::lost);
}

TEST(SchedulerLimits, JumpsBackOfASecondAreNoRestartButLongerOnesAre) {
  for (const bool by_asking : {true, false}) {
    const auto step_to = [&](Scheduler& scheduler, Stamp at) {
      if (by_asking)
        scheduler.is_due(at);
      else
        scheduler.delivered(0, at, 0.04, at);
    };
    Scheduler scheduler(1, {});
    scheduler.delivered(0, origin, 0.04, origin);
    step_to(scheduler, origin - std::chrono::seconds(1));
    EXPECT_EQ(scheduler.restarts(), 0U);
    step_to(scheduler, origin - std::chrono::seconds(1) - Span(1));
    EXPECT_EQ(scheduler.restarts(), 1U) << by_asking;
    EXPECT_EQ(scheduler.state(0, origin), by_asking ? SourceState::never : SourceState::lost);
  }
}

TEST(SchedulerLimits, AStampALittleBackDoesNotMoveTheTimeOfEvents) {
  Scheduler scheduler(1, {});
  scheduler.delivered(0, origin, 0.04, origin);
  scheduler.is_due(origin + ms(300));
  scheduler.is_due(origin + ms(100));
  ASSERT_TRUE(scheduler.next_event().has_value());
  EXPECT_EQ(*scheduler.next_event(), origin + ms(400) + Span(1)) << "what lies before 300 ms is past";
}

TEST(SchedulerLimits, ResetForgetsSourcesPeriodsAndTheLastOutput) {
  Scheduler scheduler(2, {});
  scheduler.delivered(0, origin, 0.04, origin);
  scheduler.delivered(1, origin, 0.04, origin);
  ASSERT_TRUE(scheduler.is_due(origin));
  scheduler.done(origin);
  scheduler.reset();
  EXPECT_EQ(scheduler.state(0, origin + ms(1)), SourceState::never);
  EXPECT_EQ(scheduler.period(0), 0);
  EXPECT_EQ(scheduler.deadline(), ms(30));
  EXPECT_FALSE(scheduler.next_event().has_value());
  EXPECT_FALSE(scheduler.is_due(origin + ms(1)));
  // Who is not there at the start is waited for anew.
  scheduler.reset();
  scheduler.delivered(0, origin + ms(1000), 0.04, origin + ms(1000));
  EXPECT_FALSE(scheduler.is_due(origin + ms(1000)));
}

TEST(SchedulerRate, WhatWasMissedIsNotMadeUpForAndTheGridIsKeptOtherwise) {
  ScheduleSettings settings;
  settings.policy = Policy::rate;
  settings.rate = 10;
  Scheduler scheduler(1, settings);
  const auto ask = [&](double at) {
    scheduler.delivered(0, origin + ms(at), 0.01, origin + ms(at));
    const bool due = scheduler.is_due(origin + ms(at));
    if (due) scheduler.done(origin + ms(at));
    return due;
  };
  EXPECT_TRUE(ask(0));
  EXPECT_FALSE(ask(99));
  EXPECT_TRUE(ask(104));  // late by 4 ms
  EXPECT_FALSE(ask(199));
  EXPECT_TRUE(ask(200)) << "the next one is not late for that";
  EXPECT_TRUE(ask(555));
  EXPECT_FALSE(ask(600)) << "three were missed; a new row origins";
  EXPECT_TRUE(ask(655));
}

TEST(SchedulerRate, AnOutputOutOfTurnBeginsANewRow) {
  ScheduleSettings settings;
  settings.policy = Policy::rate;
  settings.rate = 10;
  Scheduler scheduler(2, settings);
  const auto look = [&](double at) {
    const bool due = scheduler.is_due(origin + ms(at));
    if (due) scheduler.done(origin + ms(at));
    return due;
  };
  scheduler.delivered(0, origin, 0.03, origin);
  scheduler.delivered(1, origin, 0.03, origin);
  EXPECT_TRUE(look(0));
  scheduler.delivered(1, origin + ms(30), 0.03, origin + ms(30));
  EXPECT_FALSE(look(39));
  EXPECT_TRUE(look(40)) << "the first source is overdue: it must be gone from the output";
  for (double at = 60; at < 135; at += 30) scheduler.delivered(1, origin + ms(at), 0.03, origin + ms(at));
  EXPECT_FALSE(look(100));
  EXPECT_FALSE(look(139));
  EXPECT_TRUE(look(140));
  EXPECT_EQ(scheduler.deadlines_missed(), 2U);
}

TEST(SchedulerTrigger, WaitsForItsSourceUntilThatIsOverdueThoughTheOthersHaveDelivered) {
  ScheduleSettings settings;
  settings.policy = Policy::trigger;
  settings.trigger = 0;
  Scheduler scheduler(2, settings);
  const auto deliver = [&](std::size_t source, double at) {
    scheduler.delivered(source, origin + ms(at), source == 0 ? 0.1 : 0.04, origin + ms(at));
    const bool due = scheduler.is_due(origin + ms(at));
    if (due) scheduler.done(origin + ms(at));
    return due;
  };
  EXPECT_FALSE(deliver(1, 0)) << "at the start the trigger is waited for";
  EXPECT_TRUE(deliver(0, 10));
  EXPECT_FALSE(deliver(1, 40));
  EXPECT_FALSE(deliver(1, 80));
  EXPECT_TRUE(deliver(0, 110));
}

TEST(SchedulerStates, NamesAreThoseOfTheReports) {
  EXPECT_STREQ(to_string(Policy::complete), "complete");
  EXPECT_STREQ(to_string(Policy::rate), "rate");
  EXPECT_STREQ(to_string(Policy::trigger), "trigger");
  EXPECT_STREQ(to_string(SourceState::never), "never");
  EXPECT_STREQ(to_string(SourceState::ok), "ok");
  EXPECT_STREQ(to_string(SourceState::stale), "stale");
  EXPECT_STREQ(to_string(SourceState::lost), "lost");
}

}  // namespace
}  // namespace lidard
