// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/capture/tcp_reassembler.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "test/drivers/capture/pcap_testing.h"
#include "test/drivers/capture/tcp_bench.h"
#include "test/support/allocations.h"

namespace lidard::test::segments {
namespace {

using ::testing::ElementsAre;

TEST(TcpReassembler, HandsOnWhatComesInOrderAtOnce) {
  TcpBench b;
  b.add(syn(999), 1);
  b.add(segment(1000, "abc"), 2);
  b.add(segment(1003, "de"), 3);
  EXPECT_THAT(b.chunks, ElementsAre("abc", "de"));
  EXPECT_THAT(b.starts, ElementsAre(true, false));
  EXPECT_THAT(b.stamps, ElementsAre(at(2), at(3)));
  EXPECT_EQ(b.streams.counters().streams, 1U);
  EXPECT_EQ(b.streams.counters().bytes, 5U);
}

TEST(TcpReassembler, JoinsAConnectionInTheMiddle) {
  TcpBench b;
  b.add(segment(77, ""));  // an acknowledgement alone begins nothing
  EXPECT_EQ(b.streams.streams(), 0U);
  b.add(segment(77, "xyz"));
  EXPECT_THAT(b.chunks, ElementsAre("xyz"));
  EXPECT_THAT(b.starts, ElementsAre(true));
  EXPECT_THAT(b.missing, ElementsAre(0U));
}

TEST(TcpReassembler, OrdersSegmentsAndStampsThemWithTheTimeTheyCouldBeRead) {
  TcpBench b;
  b.add(segment(100, "a"), 1);
  b.add(segment(103, "d"), 2);
  b.add(segment(102, "c"), 3);
  b.add(segment(101, "b"), 4);
  b.add(segment(104, "e"), 5);
  EXPECT_THAT(b.chunks, ElementsAre("a", "b", "c", "d", "e"));
  EXPECT_THAT(b.stamps, ElementsAre(at(1), at(4), at(4), at(4), at(5)));
  EXPECT_THAT(b.missing, ElementsAre(0U, 0U, 0U, 0U, 0U));
  EXPECT_EQ(b.streams.counters().out_of_order, 2U);
  EXPECT_EQ(b.streams.waiting(), 0U);
}

TEST(TcpReassembler, UsesEachByteOnceWhateverIsSentAgain) {
  TcpBench b;
  b.add(segment(100, "abcd"));
  b.add(segment(100, "abcd"));    // sent again
  b.add(segment(102, "cdef"));    // overlaps with what is known
  b.add(segment(99, "?"));        // keep-alive: one old byte
  b.add(segment(108, "ij"));      // after a hole
  b.add(segment(108, "ij"));      // that again
  b.add(segment(108, "ijkl"));    // longer
  b.add(segment(105, "fghijk"));  // fills the hole and more
  b.add(segment(112, "m"));
  EXPECT_EQ(b.all(), "abcdefghijklm");
  EXPECT_EQ(b.streams.counters().missing, 0U);
  EXPECT_EQ(b.streams.counters().duplicates, 3U);
}

TEST(TcpReassembler, CountsOverTheWrapOfSequenceNumbers) {
  TcpBench b;
  b.add(syn(0xfffffffdU));
  b.add(segment(1, "de"));
  b.add(segment(0xfffffffeU, "abc"));
  b.add(segment(3, "f"));
  EXPECT_EQ(b.all(), "abcdef");
  EXPECT_EQ(b.streams.counters().holes, 0U);
}

TEST(TcpReassembler, GivesUpAHoleWhoseBytesTheReceiverAcknowledged) {
  TcpBench b;
  b.add(segment(100, "ab"), 1);
  b.add(segment(107, "hi"), 2);
  b.answer(107, 2.001);
  EXPECT_EQ(b.chunks.size(), 1U);
  b.add(segment(109, "j"), 2.02);
  EXPECT_THAT(b.chunks, ElementsAre("ab", "hi", "j"));
  EXPECT_THAT(b.missing, ElementsAre(0U, 5U, 0U));
  EXPECT_THAT(b.stamps, ElementsAre(at(1), at(2), at(2.02)));  // it was received when it was captured
  EXPECT_EQ(b.streams.counters().holes, 1U);
  EXPECT_EQ(b.streams.counters().missing, 5U);
}

TEST(TcpReassembler, HoldsLittleBehindAHole) {
  const std::string block(1400, 'x');
  for (const std::uint32_t step : {1U, 1400U}) {
    TcpBench b;
    b.add(segment(0, "a"));
    std::size_t most = 0;
    for (std::uint32_t i = 0; i < 3000; ++i) {
      b.add(segment(100 + i * step, std::string_view(block).substr(0, step)));
      most = std::max(most, b.streams.waiting());
    }
    EXPECT_LE(most, TcpReassembler::max_waiting_bytes + 1400);
    b.flush();
    EXPECT_EQ(b.all().size(), 1 + 3000 * step);
    EXPECT_EQ(b.streams.counters().missing, 99U);
  }
}

TEST(TcpReassembler, BeginsAgainWithANewConnectionOfTheSamePorts) {
  TcpBench b;
  b.add(syn(499));
  b.add(segment(500, "old"));
  b.add(segment(505, "waits"));
  b.add(syn(900'000'000));
  b.add(syn(900'000'000));  // sent again
  b.add(segment(900'000'001, "new"));
  EXPECT_THAT(b.chunks, ElementsAre("old", "waits", "new"));
  EXPECT_THAT(b.starts, ElementsAre(true, false, true));
  EXPECT_THAT(b.missing, ElementsAre(0U, 2U, 0U));
  EXPECT_EQ(b.streams.counters().streams, 2U);
}

TEST(TcpReassembler, BeginsAgainWhereAnEndedConnectionGoesOnElsewhere) {
  for (const bool reset : {false, true}) {
    TcpBench b;
    TcpSegment last = segment(103, "");
    (reset ? last.rst : last.fin) = true;
    b.add(segment(100, "abc"));
    b.add(last);
    b.add(segment(100, "abc"));       // sent again
    b.add(segment(50'000, "again"));  // a new connection whose SYN was not captured
    EXPECT_THAT(b.chunks, ElementsAre("abc", "again")) << reset;
    EXPECT_THAT(b.starts, ElementsAre(true, true));
    EXPECT_THAT(b.missing, ElementsAre(0U, 0U));
  }
}

TEST(TcpReassembler, BeginsAgainWhereTheSequenceJumpsFarAway) {
  TcpBench b;
  b.add(segment(100, "abc"));
  b.add(segment(3'000'000'000U, "def"));
  b.add(segment(3'000'000'003U, "ghi"));
  EXPECT_THAT(b.starts, ElementsAre(true, true, false));
  EXPECT_EQ(b.all(), "abcdefghi");
}

TEST(TcpReassembler, TakesBytesThatComeBeforeThoseOfTheLastSegment) {
  TcpBench b;
  TcpSegment last = segment(106, "ghi");
  last.fin = true;
  b.add(segment(100, "abc"));
  b.add(last);
  b.add(segment(103, "def"));
  EXPECT_EQ(b.all(), "abcdefghi");
  EXPECT_EQ(b.streams.counters().streams, 1U);
}

TEST(TcpReassembler, KeepsConnectionsAndDirectionsApart) {
  TcpReassembler streams;
  std::map<std::string, std::string> got;
  const auto drain = [&] {
    Packet packet;
    while (streams.next(packet)) {
      EXPECT_EQ(packet.transport, Transport::tcp);
      got[packet.from.to_string() + ">" + packet.to.to_string()] += packet.payload.text();
    }
  };
  const auto add = [&](const IpAddress& from, std::uint16_t from_port, const IpAddress& to,
                       std::uint16_t to_port, std::uint32_t sequence, std::string_view bytes) {
    TcpSegment one = segment(sequence, bytes);
    one.from_port = from_port, one.to_port = to_port;
    streams.add(one, from, to, at(0));
    drain();
  };
  const IpAddress other = IpAddress::v4(192, 168, 0, 2);
  add(device, 2112, host, 40000, 10, "a");
  add(host, 40000, device, 2112, 10, "q");
  add(device, 2112, host, 40001, 10, "A");
  add(other, 2112, host, 40000, 12, "2");
  add(device, 2112, host, 40000, 11, "b");
  add(other, 2112, host, 40000, 13, "3");
  add(device, 2112, host, 40001, 11, "B");
  add(host, 40000, device, 2112, 11, "r");
  EXPECT_THAT(got, ElementsAre(std::pair("192.168.0.1:2112>192.168.0.99:40000", "ab"),
                               std::pair("192.168.0.1:2112>192.168.0.99:40001", "AB"),
                               std::pair("192.168.0.2:2112>192.168.0.99:40000", "23"),
                               std::pair("192.168.0.99:40000>192.168.0.1:2112", "qr")));
}

TEST(TcpReassembler, RemembersABoundedNumberOfConnections) {
  TcpBench b;
  const std::string block(1000, 'x');
  for (std::uint32_t i = 0; i < 5000; ++i) {
    for (const std::uint32_t sequence : {0U, 2000U, 5000U}) {  // each with two holes
      TcpSegment one = segment(sequence, block);
      one.to_port = static_cast<std::uint16_t>(i);
      b.add(one, i);
    }
  }
  EXPECT_LE(b.streams.streams(), TcpReassembler::max_streams);
  EXPECT_LE(b.streams.waiting(), TcpReassembler::max_waiting_total);
  b.flush();
  EXPECT_EQ(b.streams.waiting(), 0U);
  EXPECT_EQ(b.all().size(), 15'000'000U);
}

TEST(TcpReassembler, TakesWhatTheSnapshotLengthLeft) {
  TcpBench b;
  TcpSegment cut = segment(100, "ab");
  cut.length = 10;
  b.add(cut);
  cut.sequence = 110, cut.payload = {};
  b.add(cut);
  b.add(segment(120, "cd"));
  EXPECT_THAT(b.chunks, ElementsAre("ab", "cd"));
  EXPECT_THAT(b.missing, ElementsAre(0U, 18U));
}

TEST(TcpReassembler, AllocatesNothingForSegmentsInOrder) {
  TcpReassembler streams;
  const std::string block(1448, 'x');
  Packet packet;
  std::uint32_t sequence = 0;
  const auto feed = [&](int n) {
    for (int i = 0; i < n; ++i, sequence += 1448) {
      streams.add(segment(sequence, block), device, host, at(0.001 * sequence));
      while (streams.next(packet)) {
      }
    }
  };
  feed(10);
  const std::uint64_t before = allocations();
  feed(1000);
  EXPECT_EQ(allocations(), before);
}

}  // namespace
}  // namespace lidard::test::segments
