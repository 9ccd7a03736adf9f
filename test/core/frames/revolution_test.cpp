// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/frames/revolution.h"

#include <gtest/gtest.h>

#include <cmath>
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

TEST(RevolutionCutter, ACutThatMovesEndsTheFrameAtTheNewPlace) {
  RevolutionCutter cutter(0);
  int i = 0;
  for (; i < 2000; ++i) cutter.next(wrap(0.2 * i), sequence * i);  // at 40 deg
  EXPECT_FALSE(cutter.set_cut(0.3)) << "the edges of a hidden sector wander that much";
  EXPECT_TRUE(cutter.set_cut(200));
  std::vector<double> cuts;
  for (; i < 5000; ++i) {
    if (cutter.next(wrap(0.2 * i), sequence * i) == Verdict::crossed) cuts.push_back(wrap(0.2 * i));
  }
  ASSERT_EQ(cuts.size(), 2U);
  EXPECT_NEAR(cuts[0], 200, 0.2);
  EXPECT_NEAR(cuts[1], 200, 0.2);
}

TEST(IntervalCutter, KeepsItsGridWhereFramesHadNothing) {
  IntervalCutter cutter(std::chrono::milliseconds(10));
  const auto next = [&](int ms) { return cutter.next(std::chrono::milliseconds(ms)); };
  EXPECT_FALSE(next(103));
  EXPECT_FALSE(next(112));
  EXPECT_TRUE(next(113));
  EXPECT_TRUE(next(145));  // in the frame from 143 on
  EXPECT_FALSE(next(152));
  EXPECT_TRUE(next(153));
  cutter.reset();
  EXPECT_FALSE(next(7));
  EXPECT_TRUE(next(17));
}

}  // namespace
}  // namespace lidard
