// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/start_watch.h"

#include <gtest/gtest.h>

namespace lidard {
namespace {

constexpr Stamp begin{1'700'000'000'000'000'000};
constexpr Stamp long_ago{};

Stamp after(double s) { return begin + span_from_seconds(s); }

/// A watch that saw time pass from `begin` on in steps of 0.5 s.
StartWatch watch_until(double s) {
  StartWatch watch;
  for (double at = 0; at <= s; at += 0.5) watch.step(after(at));
  return watch;
}

TEST(StartWatch, IsStartingUntilASecondHasPassedAndBeforeAnythingCame) {
  StartWatch watch;
  EXPECT_TRUE(watch.is_starting(begin, long_ago));
  EXPECT_TRUE(watch.step(begin));
  EXPECT_TRUE(watch.is_starting(after(0.99), long_ago));
  EXPECT_FALSE(watch.is_starting(after(1), long_ago));
  EXPECT_FALSE(watch.step(after(1))) << "time passes";
}

TEST(StartWatch, BeginsAgainWithAJumpOfMoreThanASecondEitherWay) {
  for (const double jump : {-1.001, 1.001, 3600.0, -3600.0}) {
    StartWatch watch = watch_until(10);
    EXPECT_FALSE(watch.is_starting(after(10), long_ago));
    EXPECT_TRUE(watch.step(after(10 + jump))) << jump;
    EXPECT_TRUE(watch.is_starting(after(10 + jump + 0.5), long_ago)) << jump;
    EXPECT_FALSE(watch.is_starting(after(10 + jump + 1), long_ago)) << jump;
  }
  for (const double no_jump : {-1.0, 1.0, 0.0}) {
    StartWatch watch = watch_until(10);
    EXPECT_FALSE(watch.step(after(10 + no_jump))) << no_jump;
  }
}

TEST(StartWatch, WhatWasAddedLaterHasASecondOfItsOwn) {
  const StartWatch watch = watch_until(10);
  EXPECT_TRUE(watch.is_starting(after(10), after(9.5)));
  EXPECT_FALSE(watch.is_starting(after(10.5), after(9.5)));
  EXPECT_FALSE(watch.is_starting(after(9), after(9.5))) << "before it was added";
}

}  // namespace
}  // namespace lidard
