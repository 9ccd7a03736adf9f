// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/merge/scheduler.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "test/core/merge/scheduler_bench.h"

namespace lidard {
namespace {

using test::Schedule;

TEST(Scheduler, CompleteFollowsTheSlowerOfTwoScanners) {
  Schedule yard({{80, 3}, {25, 11}}, 10000);
  for (const auto& output : yard.outputs) EXPECT_NE(output.use[1], 0);
  EXPECT_NEAR(yard.skip_to(1000).rate(), 12.5, 0.2);
}

TEST(Scheduler, RateIsKeptWhateverTheScannersDo) {
  ScheduleSettings settings;
  settings.policy = Policy::rate;
  settings.rate = 20;
  Schedule yard({{80, 3}, {25, 11}}, 20000, settings);
  EXPECT_NEAR(yard.skip_to(1000).rate(), 20, 0.1);
  for (const double gap : yard.gaps_ms()) EXPECT_NEAR(gap, 50, 1e-6);
}

TEST(Scheduler, TriggerFollowsItsSourceAndTakesTheOthersAsTheyAre) {
  ScheduleSettings settings;
  settings.policy = Policy::trigger;
  settings.trigger = 1;
  Schedule yard({{80, 3}, {25, 11}}, 5000, settings);
  EXPECT_NEAR(yard.skip_to(1000).rate(), 40, 0.3);
  EXPECT_NE(yard.outputs.back().use[0], 0);
}

TEST(Scheduler, OutputGoesOnAfterTheDeadlineWhenASourceDies) {
  Schedule yard({{40, 0}, {40, 5, 2000}}, 4000);
  EXPECT_LE(yard.longest_gap(), 40 + 12 + 0.001) << "0.3 of the period later than usual, once";
  EXPECT_NEAR(yard.skip_to(2000).rate(), 25, 0.6);
  EXPECT_EQ(yard.scheduler.state(1, test::origin + ms(4000)), SourceState::lost);
  EXPECT_GE(yard.scheduler.deadlines_missed(), 1U);
}

TEST(Scheduler, DeadSourceIsGoneFromTheOutputAsSoonAsItsNextSweepIsOverdueInEveryPolicy) {
  for (const Policy policy : {Policy::complete, Policy::rate, Policy::trigger}) {
    for (double phase = 0; phase < 40; ++phase) {
      ScheduleSettings settings;
      settings.policy = policy;
      Schedule yard({{40, 0}, {40, phase, 2000}}, 3000, settings);
      const Span last = ms(phase == 0 ? 1960 : 1960 + phase);
      const Span overdue = last + ms(40 + 12) + Span(1);
      const auto without = std::find_if(yard.outputs.begin(), yard.outputs.end(),
                                        [&](const auto& o) { return o.at > last && o.use[1] == 0; });
      ASSERT_NE(without, yard.outputs.end());
      EXPECT_LE(without->at, overdue) << to_string(policy) << ", " << phase << " ms";
      EXPECT_TRUE(std::all_of(without, yard.outputs.end(), [](const auto& o) { return o.use[1] == 0; }));
      EXPECT_GE(yard.scheduler.deadlines_missed(), 1U);
    }
  }
}

TEST(Scheduler, SweepsThatComeLateByLessThanTheDeadlineAreMissedByNoOutput) {
  for (const Policy policy : {Policy::complete, Policy::rate, Policy::trigger}) {
    ScheduleSettings settings;
    settings.policy = policy;
    settings.rate = 20;
    Schedule yard({{30, 0, 1e9, 1e9, 2, 8}, {31, 11, 1e9, 1e9, 25, 8}}, 30000, settings);
    for (const auto& output : yard.outputs) {
      if (output.at > ms(100)) {
        EXPECT_EQ(output.use, (std::vector<char>{1, 1})) << seconds(output.at);
      }
    }
    EXPECT_EQ(yard.scheduler.deadlines_missed(), 0U) << to_string(policy);
  }
}

TEST(Scheduler, SourceThatLagsByMoreThanItsPeriodIsNotUpToDate) {
  Schedule yard({{40, 0}, {40, 5, 1e9, 1e9, 120}}, 2000);
  for (const auto& output : yard.outputs) EXPECT_EQ(output.use[1], 0) << seconds(output.at);
  EXPECT_NEAR(yard.skip_to(1000).rate(), 25, 1);
  EXPECT_EQ(yard.scheduler.state(1, test::origin + ms(2000)), SourceState::stale);
}

TEST(Scheduler, SourceIsStaleForLongAfterTenOutputsWithoutIt) {
  Scheduler scheduler(2, {});
  Stamp now = test::origin;
  const auto make_output = [&](bool with_second, bool is_left_out) {
    now = now + ms(20);
    for (const std::size_t s : {0U, 1U})
      if (s == 0 || with_second) scheduler.delivered(s, now, 0.02, now);
    scheduler.done(now, is_left_out);
  };
  const auto lasting = [&] { return scheduler.lasting_state(1, now); };
  EXPECT_EQ(lasting(), SourceState::never);
  for (int i = 0; i < 20; ++i) make_output(true, false);
  make_output(false, false);
  ASSERT_EQ(scheduler.state(1, now), SourceState::ok) << "not yet overdue";
  for (int i = 0; i < 9; ++i) {
    make_output(false, false);
    ASSERT_EQ(scheduler.state(1, now), SourceState::stale);
    EXPECT_EQ(lasting(), SourceState::ok) << i;
  }
  make_output(false, true);
  EXPECT_EQ(lasting(), SourceState::ok) << "what is left out does not count";
  make_output(false, false);
  EXPECT_EQ(lasting(), SourceState::stale);
  scheduler.delivered(1, now, 0.02, now);
  EXPECT_EQ(lasting(), SourceState::stale) << "it is in no output yet";
  make_output(true, false);
  EXPECT_EQ(lasting(), SourceState::ok);
  now = now + ms(401);
  EXPECT_EQ(lasting(), SourceState::lost);
}

TEST(Scheduler, SlowSourceIsNotLostBetweenItsSweeps) {
  Scheduler scheduler(1, {});
  scheduler.delivered(0, test::origin, 1, test::origin);
  EXPECT_EQ(scheduler.state(0, test::origin + ms(1300)), SourceState::ok);
  EXPECT_EQ(scheduler.state(0, test::origin + ms(1300) + Span(1)), SourceState::lost);
}

TEST(Scheduler, PeriodIsLearnedAnewWhenADeviceTurnsSlowerButNotWhenSweepsAreMissing) {
  Scheduler scheduler(1, {});
  Span at{};
  const auto deliver = [&](double period) {
    at += ms(period);
    scheduler.delivered(0, test::origin + at, 0.05, test::origin + at);
  };
  for (int i = 0; i < 20; ++i) deliver(50);
  deliver(100);
  deliver(50);
  EXPECT_NEAR(scheduler.period(0), 0.05, 1e-6);
  for (int i = 0; i < 3; ++i) deliver(200);
  EXPECT_NEAR(scheduler.period(0), 0.2, 1e-6);
}

TEST(Scheduler, SourceIsLostFourTenthsOfASecondAfterItsLastSweepAndTheEventIsAnnounced) {
  Scheduler scheduler(1, {});
  scheduler.delivered(0, test::origin, 0.04, test::origin);
  EXPECT_EQ(scheduler.state(0, test::origin + ms(400)), SourceState::stale);
  EXPECT_EQ(scheduler.state(0, test::origin + ms(400) + Span(1)), SourceState::lost);
  Stamp now = test::origin;
  bool announced = false;
  while (const auto event = scheduler.next_event()) {
    ASSERT_GT(*event, now);
    now = *event;
    announced = announced || now == test::origin + ms(400) + Span(1);
    scheduler.is_due(now);
  }
  EXPECT_TRUE(announced);
}

TEST(Scheduler, LostSourceThatReturnsIsShownAtOnceInEveryPolicy) {
  for (const Policy policy : {Policy::complete, Policy::rate, Policy::trigger}) {
    ScheduleSettings settings;
    settings.policy = policy;
    Schedule yard({{40, 0}, {40, 5, 1000, 2000}}, 3000, settings);
    const auto back = std::find_if(yard.outputs.begin(), yard.outputs.end(),
                                   [](const auto& o) { return o.at >= ms(1100) && o.use[1] != 0; });
    ASSERT_NE(back, yard.outputs.end());
    EXPECT_EQ(back->at, ms(2005)) << to_string(policy);
  }
}

TEST(Scheduler, TriggerThatDiesIsReplacedByTheOthers) {
  ScheduleSettings settings;
  settings.policy = Policy::trigger;
  Schedule yard({{40, 0, 1000}, {40, 5}}, 3000, settings);
  EXPECT_NEAR(yard.skip_to(1500).rate(), 25, 1);
}

TEST(Scheduler, NothingIsPublishedWithoutAnySource) {
  ScheduleSettings settings;
  settings.policy = Policy::rate;
  Schedule silent({{40, 0, 1000}}, 3000, settings);
  EXPECT_LE(silent.outputs.back().at, ms(1100));
}

TEST(Scheduler, TimeThatJumpsBackStartsAnew) {
  Scheduler scheduler(1, {});
  const auto deliver = [&](Stamp at) {
    scheduler.delivered(0, at, 0.04, at);
    const bool due = scheduler.is_due(at);
    if (due) scheduler.done(at);
    return due;
  };
  EXPECT_TRUE(deliver(test::origin));
  EXPECT_TRUE(deliver(test::origin + ms(40)));
  EXPECT_TRUE(deliver(test::origin - std::chrono::hours(1)));
  EXPECT_EQ(scheduler.restarts(), 1U);
  EXPECT_EQ(scheduler.state(0, test::origin - std::chrono::hours(1)), SourceState::ok);
}

TEST(Scheduler, LateSweepIsNotUsedOnceItIsTooOld) {
  Scheduler scheduler(1, {});
  scheduler.delivered(0, test::origin, 0.04, test::origin);
  scheduler.delivered(0, test::origin + ms(40), 0.04, test::origin + ms(140));
  EXPECT_EQ(scheduler.state(0, test::origin + ms(140)), SourceState::stale);
  EXPECT_FALSE(scheduler.is_due(test::origin + ms(140)));
}

TEST(Scheduler, SourceThatIsNotThereAtTheStartIsWaitedForOnce) {
  Schedule yard({{40, 0}, {40, 5, 0}}, 2000);
  EXPECT_EQ(yard.outputs.front().at, ms(400) + Span(1));
  EXPECT_NEAR(yard.skip_to(600).rate(), 25, 1);
  EXPECT_EQ(yard.scheduler.state(1, test::origin + ms(2000)), SourceState::never);
}

TEST(Scheduler, HasNoOutputAndNoEventBeforeAnySource) {
  Scheduler scheduler(2, {});
  EXPECT_FALSE(scheduler.is_due(test::origin));
  EXPECT_FALSE(scheduler.next_event().has_value());
  EXPECT_EQ(scheduler.state(0, test::origin), SourceState::never);
}

}  // namespace
}  // namespace lidard
