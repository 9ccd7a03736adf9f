// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/alternation.h"

#include <gtest/gtest.h>

namespace lidard {
namespace {

TEST(Alternation, TakesTwoHardwareAddressesThatTakeTurnsForTwoDevices) {
  using namespace std::chrono_literals;
  const auto begin = Stamp{1'000'000'000};
  Alternation watch;
  watch.observe("60:76:88:00:00:01", begin);
  watch.observe("60:76:88:00:00:01", begin + 1s);
  EXPECT_EQ(watch.both(begin + 1s), "");
  watch.observe("60:76:88:00:00:02", begin + 2s);
  EXPECT_EQ(watch.both(begin + 2s), "") << "the device may have been exchanged";
  watch.observe("60:76:88:00:00:01", begin + 30s);
  EXPECT_EQ(watch.both(begin + 31s), "60:76:88:00:00:01 and 60:76:88:00:00:02");
  EXPECT_EQ(watch.both(begin + 11min), "");
  watch.observe("60:76:88:00:00:02", begin + 12min);
  EXPECT_EQ(watch.both(begin + 12min), "") << "a spare, and days later the first device again";
  watch.observe("60:76:88:00:00:01", begin + 13min);
  EXPECT_EQ(watch.both(begin + 13min), "60:76:88:00:00:01 and 60:76:88:00:00:02");
}

TEST(Alternation, CountsReturnsOfPacketsWhichFollowEachOtherSoon) {
  using namespace std::chrono_literals;
  Stamp now{1'000'000'000};
  Alternation watch(8, 10s);
  const auto take_turns = [&](int times, Span after) {
    for (int i = 0; i < times; ++i) {
      now = now + after;
      watch.observe(i % 2 == 0 ? "scanner 9" : "scanner 17", now);
    }
    return watch.both(now);
  };
  EXPECT_EQ(take_turns(20, 11s), "") << "exchanged again and again";
  EXPECT_EQ(take_turns(6, 30ms), "");
  EXPECT_EQ(take_turns(4, 30ms), "scanner 17 and scanner 9");
  now = now + 11s;
  EXPECT_EQ(watch.both(now), "") << "one of them was switched off";
}

}  // namespace
}  // namespace lidard
