// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/health/topic_watch.h"

#include <gtest/gtest.h>

namespace lidard {
namespace {

using std::chrono::milliseconds;

constexpr Stamp begin{1'700'000'000'000'000'000};

TEST(TopicWatch, TellsTheMedianAndTheTailOfLatencies) {
  TopicWatch watch;
  EXPECT_EQ(watch.figures(begin).longest_latency, Span(0));
  for (int i = 1; i <= 200; ++i) watch.published(milliseconds(i));
  const TopicFigures figures = watch.figures(begin);
  EXPECT_EQ(figures.median_latency, milliseconds(101));
  EXPECT_EQ(figures.p99_latency, milliseconds(199));
  EXPECT_EQ(figures.longest_latency, milliseconds(200));
}

TEST(TopicWatch, CountsNoLatencyOverAStepThatNobodyHasNoticedYet) {
  TopicWatch watch;
  for (const Span latency : {Span(milliseconds(3)), Span(std::chrono::hours(1)), Span(-milliseconds(1))})
    watch.published(latency);
  EXPECT_EQ(watch.figures(begin).longest_latency, milliseconds(3));
  EXPECT_EQ(watch.figures(begin).median_latency, milliseconds(3));
}

TEST(TopicWatch, ForgetsLatenciesOfLongAgo) {
  TopicWatch watch;
  watch.published(std::chrono::seconds(9));
  for (int i = 0; i < 512; ++i) watch.published(milliseconds(1));
  EXPECT_EQ(watch.figures(begin).longest_latency, milliseconds(1));
}

TEST(TopicWatch, TellsRateAndGapsOfTheLastTenSeconds) {
  TopicWatch watch;
  watch.released(begin);
  EXPECT_EQ(watch.figures(begin).rate_hz, 0) << "one frame has no rate";
  Stamp at = begin + std::chrono::seconds(100);
  for (int i = 0; i < 100; ++i) {
    watch.released(at);
    at = at + milliseconds(i == 50 ? 120 : 100);
  }
  const Stamp last = at - milliseconds(100);
  TopicFigures figures = watch.figures(last);
  EXPECT_EQ(figures.frames, 101U);
  EXPECT_NEAR(figures.rate_hz, 10, 0.05);
  EXPECT_EQ(figures.shortest_gap, milliseconds(100));
  EXPECT_EQ(figures.longest_gap, milliseconds(120)) << "the 100 s before are past";
  figures = watch.figures(last + std::chrono::seconds(20));
  EXPECT_EQ(figures.rate_hz, 0) << "nothing came for 20 s";
  EXPECT_EQ(figures.longest_gap, Span(0));
}

}  // namespace
}  // namespace lidard
