// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/merge/scheduler.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "test/sim/world/units.h"

namespace lidard {
namespace {

constexpr Stamp begin{1'700'000'000'000'000'000};

/// Scanners of fixed rates on a virtual clock, and the outputs that a scheduler makes of them.
class Yard {
 public:
  struct Scanner {
    Span period;
    Span phase;
    std::optional<Span> silent_from{};
    std::optional<Span> back_at{};
    Span delay{};   // of every sweep, from its last ray to its arrival
    Span jitter{};  // and of some, at most
    Span end{};
    Span next{};
    unsigned sweeps = 0;
  };
  struct Output {
    Span at;
    std::vector<char> use;
  };

  Yard(std::vector<Scanner> scanners, const ScheduleSettings& settings)
      : scheduler(scanners.size(), settings), scanners_(std::move(scanners)) {
    for (Scanner& s : scanners_) {
      s.end = s.phase;
      s.next = s.phase + s.delay;
    }
  }

  /// Lets time pass until `end`, from event to event and no finer than these.
  void run(Span end) {
    for (;;) {
      const auto first = std::min_element(scanners_.begin(), scanners_.end(),
                                          [](const auto& a, const auto& b) { return a.next < b.next; });
      Span at = first->next;
      const auto event = scheduler.next_event();
      const bool timer = event && *event - begin < at;
      if (timer) at = *event - begin;
      if (at > end) return;
      if (!timer) deliver(static_cast<std::size_t>(first - scanners_.begin()));
      look(at);
    }
  }

  std::vector<Span> gaps() const {
    std::vector<Span> all;
    for (std::size_t i = 1; i < outputs.size(); ++i) all.push_back(outputs[i].at - outputs[i - 1].at);
    return all;
  }
  double rate(Span from, Span to) const {
    const auto count = std::count_if(outputs.begin(), outputs.end(),
                                     [&](const Output& o) { return o.at >= from && o.at < to; });
    return static_cast<double>(count) / seconds(to - from);
  }

  Scheduler scheduler;
  std::vector<Output> outputs;

 private:
  void deliver(std::size_t index) {
    Scanner& s = scanners_[index];
    const bool silent = s.silent_from && s.next >= *s.silent_from && (!s.back_at || s.next < *s.back_at);
    if (!silent) scheduler.delivered(index, begin + s.end, seconds(s.period), begin + s.next);
    s.end += s.period;
    s.next = s.end + s.delay + s.jitter * (++s.sweeps * 7919 % 101) / 100;
  }
  void look(Span at) {
    if (!scheduler.is_due(begin + at)) return;
    outputs.push_back({at, scheduler.usable(begin + at)});
    scheduler.done(begin + at);
  }

  std::vector<Scanner> scanners_;
};

TEST(Scheduler, CompleteFollowsTheSlowerOfTwoScanners) {
  Yard yard({{ms(80), ms(3)}, {ms(25), ms(11)}}, {});
  yard.run(std::chrono::seconds(10));
  EXPECT_NEAR(yard.rate(std::chrono::seconds(1), std::chrono::seconds(9)), 12.5, 0.2);
  for (const auto& output : yard.outputs) EXPECT_NE(output.use[1], 0);
}

TEST(Scheduler, RateIsKeptWhateverTheScannersDo) {
  ScheduleSettings settings;
  settings.policy = Policy::rate;
  settings.rate = 20;
  Yard yard({{ms(80), ms(3)}, {ms(25), ms(11)}}, settings);
  yard.run(std::chrono::seconds(20));
  EXPECT_NEAR(yard.rate(std::chrono::seconds(1), std::chrono::seconds(19)), 20, 0.1);
  for (const Span gap : yard.gaps()) EXPECT_EQ(gap, ms(50));
}

TEST(Scheduler, TriggerFollowsItsSourceAndTakesTheOthersAsTheyAre) {
  ScheduleSettings settings;
  settings.policy = Policy::trigger;
  settings.trigger = 1;
  Yard yard({{ms(80), ms(3)}, {ms(25), ms(11)}}, settings);
  yard.run(std::chrono::seconds(5));
  EXPECT_NEAR(yard.rate(std::chrono::seconds(1), std::chrono::seconds(5)), 40, 0.3);
  EXPECT_NE(yard.outputs.back().use[0], 0);
}

TEST(Scheduler, OutputGoesOnAfterTheDeadlineWhenASourceDies) {
  Yard yard({{ms(40), ms(0)}, {ms(40), ms(5), ms(2000)}}, {});
  yard.run(std::chrono::seconds(4));
  const auto gaps = yard.gaps();
  // 0.3 of the period later than usual, once.
  EXPECT_LE(*std::max_element(gaps.begin(), gaps.end()), ms(40 + 12 + 0.001));
  EXPECT_NEAR(yard.rate(std::chrono::seconds(2), std::chrono::seconds(4)), 25, 0.6);
  EXPECT_EQ(yard.scheduler.state(1, begin + ms(4000)), SourceState::lost);
  EXPECT_GE(yard.scheduler.deadlines_missed(), 1U);
}

TEST(Scheduler, DeadSourceIsGoneFromTheOutputAsSoonAsItsNextSweepIsOverdueInEveryPolicy) {
  for (const Policy policy : {Policy::complete, Policy::rate, Policy::trigger}) {
    for (int phase = 0; phase < 40; ++phase) {
      ScheduleSettings settings;
      settings.policy = policy;
      Yard yard({{ms(40), ms(0)}, {ms(40), ms(phase), ms(2000)}}, settings);
      yard.run(ms(3000));
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
    Yard yard({{ms(30), ms(0), {}, {}, ms(2), ms(8)}, {ms(31), ms(11), {}, {}, ms(25), ms(8)}}, settings);
    yard.run(std::chrono::seconds(30));
    for (const auto& output : yard.outputs) {
      if (output.at > ms(100)) {
        EXPECT_EQ(output.use, (std::vector<char>{1, 1})) << seconds(output.at);
      }
    }
    EXPECT_EQ(yard.scheduler.deadlines_missed(), 0U) << to_string(policy);
  }
}

TEST(Scheduler, SourceThatLagsByMoreThanItsPeriodIsNotUpToDate) {
  Yard yard({{ms(40), ms(0)}, {ms(40), ms(5), {}, {}, ms(120)}}, {});
  yard.run(std::chrono::seconds(2));
  for (const auto& output : yard.outputs) EXPECT_EQ(output.use[1], 0) << seconds(output.at);
  EXPECT_NEAR(yard.rate(ms(1000), ms(2000)), 25, 1);
  EXPECT_EQ(yard.scheduler.state(1, begin + ms(2000)), SourceState::stale);
}

TEST(Scheduler, SlowSourceIsNotLostBetweenItsSweeps) {
  Scheduler scheduler(1, {});
  scheduler.delivered(0, begin, 1, begin);
  EXPECT_EQ(scheduler.state(0, begin + ms(1300)), SourceState::ok);
  EXPECT_EQ(scheduler.state(0, begin + ms(1300) + Span(1)), SourceState::lost);
}

TEST(Scheduler, PeriodIsLearnedAnewWhenADeviceTurnsSlowerButNotWhenSweepsAreMissing) {
  Scheduler scheduler(1, {});
  Span at{};
  const auto deliver = [&](double period) {
    at += ms(period);
    scheduler.delivered(0, begin + at, 0.05, begin + at);
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
  scheduler.delivered(0, begin, 0.04, begin);
  EXPECT_EQ(scheduler.state(0, begin + ms(400)), SourceState::stale);
  EXPECT_EQ(scheduler.state(0, begin + ms(400) + Span(1)), SourceState::lost);
  Stamp now = begin;
  bool announced = false;
  while (const auto event = scheduler.next_event()) {
    ASSERT_GT(*event, now);
    now = *event;
    announced = announced || now == begin + ms(400) + Span(1);
    scheduler.is_due(now);
  }
  EXPECT_TRUE(announced);
}

TEST(Scheduler, LostSourceThatReturnsIsShownAtOnceInEveryPolicy) {
  for (const Policy policy : {Policy::complete, Policy::rate, Policy::trigger}) {
    ScheduleSettings settings;
    settings.policy = policy;
    Yard yard({{ms(40), ms(0)}, {ms(40), ms(5), ms(1000), ms(2000)}}, settings);
    yard.run(std::chrono::seconds(3));
    const auto back = std::find_if(yard.outputs.begin(), yard.outputs.end(),
                                   [](const auto& o) { return o.at >= ms(1100) && o.use[1] != 0; });
    ASSERT_NE(back, yard.outputs.end());
    EXPECT_EQ(back->at, ms(2005)) << to_string(policy);
  }
}

TEST(Scheduler, TriggerThatDiesIsReplacedByTheOthers) {
  ScheduleSettings settings;
  settings.policy = Policy::trigger;
  Yard yard({{ms(40), ms(0), ms(1000)}, {ms(40), ms(5)}}, settings);
  yard.run(std::chrono::seconds(3));
  EXPECT_NEAR(yard.rate(ms(1500), ms(3000)), 25, 1);
}

TEST(Scheduler, NothingIsPublishedWithoutAnySource) {
  ScheduleSettings settings;
  settings.policy = Policy::rate;
  Yard silent({{ms(40), ms(0), ms(1000)}}, settings);
  silent.run(std::chrono::seconds(3));
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
  EXPECT_TRUE(deliver(begin));
  EXPECT_TRUE(deliver(begin + ms(40)));
  EXPECT_TRUE(deliver(begin - std::chrono::hours(1)));
  EXPECT_EQ(scheduler.restarts(), 1U);
  EXPECT_EQ(scheduler.state(0, begin - std::chrono::hours(1)), SourceState::ok);
}

TEST(Scheduler, LateSweepIsNotUsedOnceItIsTooOld) {
  Scheduler scheduler(1, {});
  scheduler.delivered(0, begin, 0.04, begin);
  scheduler.delivered(0, begin + ms(40), 0.04, begin + ms(140));
  EXPECT_EQ(scheduler.state(0, begin + ms(140)), SourceState::stale);
  EXPECT_FALSE(scheduler.is_due(begin + ms(140)));
}

TEST(Scheduler, SourceThatIsNotThereAtTheStartIsWaitedForOnce) {
  Yard yard({{ms(40), ms(0)}, {ms(40), ms(5), ms(0)}}, {});
  yard.run(std::chrono::seconds(2));
  EXPECT_EQ(yard.outputs.front().at, ms(400) + Span(1));
  EXPECT_NEAR(yard.rate(ms(600), ms(2000)), 25, 1);
  EXPECT_EQ(yard.scheduler.state(1, begin + ms(2000)), SourceState::never);
}

TEST(Scheduler, HasNoOutputAndNoEventBeforeAnySource) {
  Scheduler scheduler(2, {});
  EXPECT_FALSE(scheduler.is_due(begin));
  EXPECT_FALSE(scheduler.next_event().has_value());
  EXPECT_EQ(scheduler.state(0, begin), SourceState::never);
}

}  // namespace
}  // namespace lidard
