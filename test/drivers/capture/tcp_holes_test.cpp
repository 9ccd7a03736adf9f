// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Several holes in one stream: each is waited for on its own account.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "test/drivers/capture/tcp_bench.h"

namespace lidard::test::segments {
namespace {

using ::testing::ElementsAre;

TEST(TcpHoles, TheSecondHoleDoesNotInheritTheAcknowledgementOfTheFirst) {
  TcpBench b;
  b.add(segment(100, "ab"), 1);
  b.add(segment(104, "ef"), 1.1);
  b.add(segment(108, "ij"), 1.2);
  b.answer(106, 1.21);               // the receiver has what lies in the first hole
  b.add(segment(102, "cd"), 1.215);  // and so has the capture, late
  EXPECT_EQ(b.all(), "abcdef");
  b.add(segment(110, "kl"), 1.5);
  EXPECT_EQ(b.all(), "abcdef") << "nobody acknowledged what lies in the second hole";
  b.add(segment(106, "gh"), 1.6);
  EXPECT_EQ(b.all(), "abcdefghijkl");
  EXPECT_EQ(b.streams.counters().holes, 0U);
}

TEST(TcpHoles, TheSecondHoleIsWaitedForFromWhenItWasSeen) {
  TcpBench b;
  b.add(segment(100, "ab"), 1);
  b.add(segment(104, "ef"), 2);
  b.add(segment(108, "ij"), 4);
  b.add(segment(102, "cd"), 4.5);  // the first hole, seen at 2, is filled
  EXPECT_EQ(b.all(), "abcdef");
  b.streams.expire(at(6.9));
  b.drain();
  EXPECT_EQ(b.all(), "abcdef") << "the second one is there since 4";
  b.streams.expire(at(7.1));
  b.drain();
  EXPECT_EQ(b.all(), "abcdefij");
  EXPECT_EQ(b.streams.counters().holes, 1U);
  EXPECT_EQ(b.streams.counters().missing, 2U);
}

TEST(TcpHoles, AHoleIsGivenUpTenMillisecondsAfterItsAcknowledgementAndNotBefore) {
  TcpBench b;
  b.add(segment(100, "ab"), 1);
  b.add(segment(104, "ef"), 2);
  b.answer(104, 2.5);
  b.streams.expire(at(2.5099));
  b.drain();
  EXPECT_EQ(b.all(), "ab");
  b.answer(104, 2.509);  // a second acknowledgement does not begin anew
  b.streams.expire(at(2.5101));
  b.drain();
  EXPECT_EQ(b.all(), "abef");
}

TEST(TcpHoles, AnAcknowledgementThatEndsBeforeWhatWaitsSaysNothing) {
  TcpBench b;
  b.add(segment(100, "ab"), 1);
  b.add(segment(104, "ef"), 2);
  b.answer(103, 2);
  b.streams.expire(at(2.9));
  b.drain();
  EXPECT_EQ(b.all(), "ab") << "one byte of the hole may still come again";
  b.answer(104, 2.9);
  b.streams.expire(at(2.92));
  b.drain();
  EXPECT_EQ(b.all(), "abef");
}

TEST(TcpHoles, ANewHoleAfterAClosedOneBeginsItsOwnPatience) {
  TcpBench b;
  b.add(segment(100, "ab"), 0);
  for (int i = 0; i < 5; ++i) {
    const auto base = static_cast<std::uint32_t>(102 + 4 * i);
    b.add(segment(base + 2, "yz"), 2.0 * i);
    b.answer(base + 4, 2.0 * i);
    b.add(segment(base, "wx"), 2.0 * i + 0.005);
    EXPECT_EQ(b.all().size(), 2U + 4U * static_cast<unsigned>(i + 1));
  }
  EXPECT_EQ(b.streams.counters().holes, 0U);
  // Not acknowledged, so it lasts the whole patience.
  b.add(segment(130, "q"), 20);
  b.streams.expire(at(22.9));
  b.drain();
  EXPECT_EQ(b.all().size(), 22U);
  b.streams.expire(at(23.1));
  b.drain();
  EXPECT_EQ(b.all().size(), 23U);
  EXPECT_EQ(b.missing.back(), 8U);
}

TEST(TcpHoles, EachChunkSaysWhatIsMissingRightBeforeItAlone) {
  TcpBench b;
  b.add(segment(100, "ab"));
  b.add(segment(105, "fg"));
  b.add(segment(108, "ij"));
  b.add(segment(120, "uv"));
  b.flush();
  EXPECT_THAT(b.chunks, ElementsAre("ab", "fg", "ij", "uv"));
  EXPECT_THAT(b.missing, ElementsAre(0U, 3U, 1U, 10U));
  b.add(segment(122, "wx"));
  EXPECT_EQ(b.missing.back(), 0U);
}

TEST(TcpHoles, AnotherConnectionWithTheSamePortsInheritsNothing) {
  TcpBench b;
  b.add(segment(100, "ab"), 1);
  b.add(segment(104, "ef"), 1.1);
  b.answer(106, 1.1);
  b.add(syn(5000), 1.105);
  b.add(segment(5001, "xy"), 1.2);
  b.add(segment(5005, "12"), 1.3);
  b.streams.expire(at(2));
  b.drain();
  EXPECT_THAT(b.chunks, ElementsAre("ab", "ef", "xy")) << "its own hole was not acknowledged";
  EXPECT_THAT(b.starts, ElementsAre(true, false, true));
}

TEST(TcpHoles, ARestartForgetsWhatWaitsAndGoesOnCounting) {
  TcpBench b;
  b.add(segment(100, "ab"), 1);
  b.add(segment(104, "ef"), 1.1);
  b.streams.restart();
  b.drain();
  EXPECT_EQ(b.streams.waiting(), 0U);
  EXPECT_EQ(b.streams.streams(), 0U);
  b.add(segment(100, "ab"), 0.5);
  b.add(segment(102, "cd"), 0.6);
  EXPECT_THAT(b.chunks, ElementsAre("ab", "ab", "cd"));
  EXPECT_THAT(b.starts, ElementsAre(true, true, false));
  EXPECT_EQ(b.streams.counters().streams, 2U);
}

}  // namespace
}  // namespace lidard::test::segments
