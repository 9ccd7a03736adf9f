// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/frames/revolution.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace lidard {
namespace {

using Verdict = RevolutionCutter::Verdict;
constexpr Span sequence = std::chrono::nanoseconds(55296);

double wrap(double a) { return std::fmod(std::fmod(a, 360) + 360, 360); }

TEST(RevolutionCutter, CutsOncePerTurnAtAnyAngle) {
  for (int cut = 0; cut < 360; ++cut) {
    RevolutionCutter cutter(cut);
    int cuts = 0;
    double previous = 0;
    for (int i = 0; i < 20 * 1800; ++i) {
      const double azimuth = wrap(17.3 + 0.2 * i);
      if (cutter.next(azimuth, sequence * i) == Verdict::crossed) {
        ++cuts;
        ASSERT_LT(wrap(azimuth - cut), 0.2 + 1e-9) << cut;
        ASSERT_GT(wrap(previous - cut), 359) << cut;
      }
      previous = azimuth;
    }
    ASSERT_EQ(cuts, 20) << cut;
    EXPECT_NEAR(seconds(cutter.period()), 1800 * seconds(sequence), 1e-6);
  }
}

TEST(RevolutionCutter, JitterBackwardsAtTheCutDoesNotCutTwice) {
  RevolutionCutter cutter(0);
  int cuts = 0;
  for (int i = 0; i < 3600; ++i) {
    const double jitter = i % 2 == 0 ? 0.0 : -0.35;
    if (cutter.next(wrap(350 + 0.1 * i + jitter), sequence * i) != Verdict::same) ++cuts;
  }
  EXPECT_EQ(cuts, 1);
}

TEST(RevolutionCutter, CutsInsideAHiddenSector) {
  for (const double cut : {0.0, 120.0, 180.0, 300.0}) {
    RevolutionCutter cutter(cut);
    int cuts = 0;
    for (int turn = 0; turn < 10; ++turn) {
      for (int i = 0; i < 450; ++i) {  // 270 deg ... 360 deg only
        const Span time = sequence * (turn * 1800 + i);
        if (cutter.next(wrap(270 + 0.2 * i), time) == Verdict::crossed) ++cuts;
      }
    }
    EXPECT_EQ(cuts, cut == 300 ? 10 : 9) << cut;
  }
}

TEST(RevolutionCutter, StandingMotorIsCutByTime) {
  RevolutionCutter cutter(0);
  int forced = 0;
  for (int i = 0; i < 100000; ++i) {
    if (cutter.next(45, sequence * i) == Verdict::forced) ++forced;
  }
  EXPECT_EQ(forced, static_cast<int>(100000 * seconds(sequence) / 1.5));
}

TEST(RevolutionCutter, AMissingTurnEndsTheFrameAlsoWhereTheAzimuthGoesOn) {
  RevolutionCutter cutter(0);
  int i = 0;
  for (; i < 2300; ++i) cutter.next(wrap(0.2 * i), sequence * i);  // at 100 deg of the second turn
  i += 1810;
  EXPECT_EQ(cutter.next(wrap(0.2 * i), sequence * i), Verdict::forced);
  EXPECT_NEAR(seconds(cutter.period()), 1800 * seconds(sequence), 1e-6);
}

/// A lidar that turns once in 100 ms and sends every 0.2 degrees.
class Turning {
 public:
  explicit Turning(double cut = 0) : cutter(cut) {}
  /// Sends until it has turned so far, then nothing until `gap_deg` more; the verdict on what comes then. The
  /// motor turns `faster` than before during the gap.
  Verdict after_gap(double until_deg, double gap_deg, double faster = 1) {
    for (; turned < until_deg; turned += 0.2) {
      const Verdict verdict = cutter.next(wrap(turned), span_from_seconds(turned / 3600));
      if (verdict != Verdict::same) last_cut = turned;
    }
    const double since = turned - 0.2;
    turned = since + gap_deg;
    return cutter.next(wrap(turned), span_from_seconds((since + gap_deg / faster) / 3600));
  }
  RevolutionCutter cutter;
  double turned = 0, last_cut = 0;
};

TEST(RevolutionCutter, AfterAGapOfAnyLengthItTellsWhetherATurnIsMissing) {
  int missing = 0, crossed = 0, same = 0;
  for (const double faster : {0.985, 1.0, 1.015}) {
    for (double until = 1000; until < 1400; until += 53) {
      for (double gap = 1; gap < 1300; gap += 31) {
        Turning lidar;
        const Verdict verdict = lidar.after_gap(until, gap, faster);
        const double begin = lidar.turned - gap;
        const double whole = std::floor(gap / 360);
        const double passed = std::floor(lidar.turned / 360) - std::floor(begin / 360);
        // A frame that gets more than one and a half turns of time is given up too.
        const double frame = lidar.turned - gap - lidar.last_cut + gap / faster;
        if (std::abs(frame - 540) < 12) continue;
        const Verdict expected = whole > 0 || frame > 540 ? Verdict::forced
                                 : passed > 0             ? Verdict::crossed
                                                          : Verdict::same;
        ASSERT_EQ(verdict, expected) << "gap of " << gap << " at " << begin << ", speed " << faster;
        ++(expected == Verdict::forced ? missing : expected == Verdict::crossed ? crossed : same);
      }
    }
  }
  EXPECT_GT(missing, 400);
  EXPECT_GT(crossed, 50);
  EXPECT_GT(same, 40);
}

TEST(RevolutionCutter, ATurnThatIsMissingEndsTheFrameThoughThePeriodSaysALittleLess) {
  // The motor turns faster than was measured: a turn and 2 degrees in the time of 0.99 turns.
  Turning lidar;
  EXPECT_EQ(lidar.after_gap(1100, 362, 362 / (0.99 * 360)), Verdict::forced);
  EXPECT_NEAR(seconds(lidar.cutter.period()), 0.1, 0.005);
}

TEST(RevolutionCutter, TheRateIsMeasuredAcrossAGapToo) {
  Turning lidar;
  lidar.after_gap(1100, 800);
  EXPECT_NEAR(seconds(lidar.cutter.period()), 0.1, 1e-4);
}

TEST(RevolutionCutter, StepsBackOfLessThanADegreeAreJitterAndLongerOnesAreATurn) {
  const auto cuts_after_step_back = [](double back) {
    RevolutionCutter cutter(0);
    for (int i = 0; i < 100; ++i) cutter.next(wrap(300 + 0.2 * i), sequence * i);
    return cutter.next(wrap(300 + 0.2 * 99 - back), sequence * 100) == Verdict::crossed;
  };
  EXPECT_FALSE(cuts_after_step_back(0.5));
  EXPECT_FALSE(cuts_after_step_back(0.95));
  EXPECT_TRUE(cuts_after_step_back(1.05));
  EXPECT_TRUE(cuts_after_step_back(40));
}

TEST(RevolutionCutter, ACutAtASequencesVeryAzimuthBeginsWithIt) {
  for (const double cut : {0.0, 90.0, 359.8}) {
    RevolutionCutter cutter(cut);
    for (int i = 0; i < 3000; ++i) {
      const double azimuth = wrap(std::round(2 * i) / 10);
      if (cutter.next(azimuth, sequence * i) == Verdict::crossed) {
        EXPECT_NEAR(std::remainder(azimuth - cut, 360), 0, 1e-9) << i;
      }
    }
  }
}

TEST(RevolutionCutter, ResetForgetsTheRateAndTheFrame) {
  Turning lidar;
  lidar.after_gap(1100, 1);
  ASSERT_NE(lidar.cutter.period().count(), 0);
  lidar.cutter.reset();
  EXPECT_EQ(lidar.cutter.period().count(), 0);
  EXPECT_EQ(lidar.cutter.next(5, std::chrono::hours(1)), Verdict::same) << "the first of a new frame";
  EXPECT_EQ(lidar.cutter.next(90, std::chrono::hours(1) + std::chrono::milliseconds(900)), Verdict::same)
      << "no rate is known that a turn could be missing by";
}

TEST(RevolutionCutter, AFrameLastsOneAndAHalfTurnsAtMostAndASecondAndAHalfUntilTheRateIsKnown) {
  RevolutionCutter unknown(0);
  unknown.next(10, Span(0));
  EXPECT_EQ(unknown.next(10, std::chrono::milliseconds(1500)), Verdict::same);
  EXPECT_EQ(unknown.next(10, std::chrono::milliseconds(1500) + Span(1)), Verdict::forced);
  // Once the motor turned it stands still: 100 ms a turn, so that 150 ms end the frame.
  Turning lidar;
  lidar.after_gap(1081, 0.2);
  const Span stopped = span_from_seconds(lidar.turned / 3600);
  const auto forced_by = [&](int ms) {
    return lidar.cutter.next(wrap(lidar.turned), stopped + std::chrono::milliseconds(ms)) == Verdict::forced;
  };
  for (int ms = 5; ms < 148; ms += 5) EXPECT_FALSE(forced_by(ms)) << ms;
  EXPECT_FALSE(forced_by(149));
  EXPECT_TRUE(forced_by(151));
}

TEST(RevolutionCutter, SequencesPassedAtOnceLeaveTheStateThatEachOfThemLeaves) {
  std::mt19937 random(5);
  for (int cut = 0; cut < 360; cut += 7) {
    RevolutionCutter each(cut), at_once(cut);
    auto azimuth = static_cast<double>(random() % 360);
    Span time{0};
    int passed = 0;
    for (int packet = 0; packet < 3000; ++packet) {
      // A lost packet, a lost turn and a step back now and then.
      const int lost = random() % 50 == 0 ? static_cast<int>(random() % 2000) : 0;
      azimuth += 0.2 * lost - (random() % 40 == 0 ? 0.5 : 0);
      time += sequence * lost;
      const double first = wrap(azimuth);
      const bool even = first + 0.2 * 23 < 360;
      const bool is_passed = even && at_once.pass(first, first + 0.2 * 23, time, time + sequence * 23);
      passed += is_passed ? 1 : 0;
      for (int i = 0; i < 24; ++i) {
        const double now = even ? first + 0.2 * i : wrap(azimuth + 0.2 * i);
        const Verdict verdict = each.next(now, time + sequence * i);
        ASSERT_EQ(verdict, is_passed ? Verdict::same : at_once.next(now, time + sequence * i)) << packet;
      }
      ASSERT_EQ(each.period(), at_once.period()) << packet;
      azimuth += 0.2 * 24;
      time += sequence * 24;
    }
    EXPECT_GT(passed, 2000) << "most packets lie within a turn";
  }
}

}  // namespace
}  // namespace lidard
