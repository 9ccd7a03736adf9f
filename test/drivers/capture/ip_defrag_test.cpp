// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

#include "drivers/capture/ip_packet.h"
#include "test/drivers/capture/pcap_testing.h"

namespace lidard::test {
namespace {

constexpr Stamp start{1'700'000'000'000'000'000};

/// One fragment of `whole`.
struct Part {
  std::size_t offset, length;
  bool more;
};

class Defragmenting : public ::testing::Test {
 protected:
  /// The whole packet if `bytes` completed one.
  std::optional<Bytes> add(const Bytes& bytes, bool v6, Stamp now = start) {
    kept_ = bytes;
    IpPacket packet;
    EXPECT_EQ(parse_ip(view(kept_), v6, packet), HeaderResult::ok);
    last = defragmenter.add(packet, now);
    if (last != DefragResult::complete) return std::nullopt;
    return Bytes(packet.transport.begin(), packet.transport.end());
  }
  std::optional<Bytes> add(const Part& part, std::uint16_t id = 1, Stamp now = start) {
    V4 o;
    o.id = id, o.offset = part.offset, o.more = part.more;
    return add(ipv4(slice(part), o), false, now);
  }
  Bytes slice(const Part& part) const {
    const auto begin = whole.begin() + static_cast<std::ptrdiff_t>(part.offset);
    return {begin, begin + static_cast<std::ptrdiff_t>(part.length)};
  }

  const Bytes whole = counting(100, 3);
  const std::vector<Part> parts{{0, 24, true}, {24, 24, true}, {48, 24, true}, {72, 28, false}};
  IpDefragmenter defragmenter;
  DefragResult last = DefragResult::waiting;

 private:
  Bytes kept_;
};

TEST_F(Defragmenting, PutsFragmentsTogetherInEveryOrder) {
  std::vector<std::size_t> order{0, 1, 2, 3};
  int orders = 0;
  do {
    for (std::size_t i = 0; i < 3; ++i) EXPECT_FALSE(add(parts[order[i]]));
    EXPECT_EQ(add(parts[order[3]]), whole);
    ++orders;
  } while (std::next_permutation(order.begin(), order.end()));
  EXPECT_EQ(orders, 24);
  EXPECT_EQ(defragmenter.dropped(), 0U);
  EXPECT_EQ(defragmenter.pending(), 0U);
}

TEST_F(Defragmenting, PutsIpv6FragmentsTogetherInEveryOrder) {
  std::vector<std::size_t> order{0, 1, 2, 3};
  do {
    std::optional<Bytes> got;
    for (const std::size_t i : order) {
      EXPECT_FALSE(got);
      got = add(ipv6_fragment(slice(parts[i]), 77, parts[i].offset, parts[i].more), true);
    }
    EXPECT_EQ(got, whole);
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST_F(Defragmenting, CountsAFragmentThatComesTwiceAndUsesItOnce) {
  EXPECT_FALSE(add(parts[0]));
  EXPECT_FALSE(add(parts[0]));
  EXPECT_FALSE(add(parts[3]));
  EXPECT_FALSE(add(parts[2]));
  EXPECT_FALSE(add(parts[3]));
  EXPECT_EQ(add(parts[1]), whole);
  EXPECT_EQ(defragmenter.dropped(), 2U);
}

TEST_F(Defragmenting, AcceptsOverlapWithTheSameContent) {
  EXPECT_FALSE(add({0, 48, true}));
  EXPECT_FALSE(add({24, 48, true}));
  EXPECT_EQ(add({64, 36, false}), whole);
  EXPECT_EQ(defragmenter.dropped(), 0U);
}

TEST_F(Defragmenting, DropsThePacketWhoseFragmentsContradictEachOther) {
  add(parts[0]);
  add(parts[1]);
  V4 o;
  o.id = 1, o.offset = 40, o.more = true;
  EXPECT_FALSE(add(ipv4(Bytes(16, 0xff), o), false));
  EXPECT_EQ(defragmenter.dropped(), 3U);
  EXPECT_FALSE(add(parts[2]));
  EXPECT_FALSE(add(parts[3]));
  defragmenter.flush();
  EXPECT_EQ(defragmenter.dropped(), 5U);
}

TEST_F(Defragmenting, DropsThePacketWithTwoDifferentEnds) {
  add(parts[3]);
  EXPECT_FALSE(add({72, 20, false}));
  EXPECT_EQ(defragmenter.dropped(), 2U);
  add(parts[2]);
  EXPECT_FALSE(add({8, 16, false}));  // an end before what is there already
  EXPECT_EQ(defragmenter.dropped(), 4U);
  add(Part{8, 16, false}, 2);
  EXPECT_FALSE(add(Part{16, 16, true}, 2));  // goes on behind the end
  EXPECT_EQ(defragmenter.dropped(), 6U);
}

TEST_F(Defragmenting, NeverFinishesAPacketWithAHole) {
  add(parts[0]);
  add(parts[3]);
  EXPECT_FALSE(add(parts[1]));
  EXPECT_EQ(defragmenter.pending(), 1U);
  EXPECT_EQ(defragmenter.dropped(), 0U);
  defragmenter.flush();
  EXPECT_EQ(defragmenter.dropped(), 3U);
  EXPECT_EQ(defragmenter.pending(), 0U);
}

TEST_F(Defragmenting, TellsPacketsApartBySenderReceiverProtocolAndNumber) {
  V4 a, b, c;
  a.id = b.id = c.id = 9;
  a.more = b.more = c.more = true;
  b.protocol = 6;
  c.last_of_sender = 202;
  add(ipv4(Bytes(8, 1), a), false);
  add(ipv4(Bytes(8, 2), b), false);
  add(ipv4(Bytes(8, 3), c), false);
  EXPECT_EQ(defragmenter.pending(), 3U);
  a.offset = c.offset = 8;
  a.more = c.more = false;
  EXPECT_EQ(add(ipv4(Bytes(3, 4), c), false), Bytes(8, 3) + Bytes(3, 4));
  EXPECT_EQ(add(ipv4(Bytes(3, 5), a), false), Bytes(8, 1) + Bytes(3, 5));
}

TEST_F(Defragmenting, GivesUpAfterTheTimeOutOfCaptureTime) {
  add(parts[0], 1, start);
  add(parts[1], 2, start + IpDefragmenter::time_out);
  EXPECT_EQ(defragmenter.pending(), 2U);
  add(parts[1], 3, start + IpDefragmenter::time_out + Span(1));
  EXPECT_EQ(defragmenter.pending(), 2U);
  EXPECT_EQ(defragmenter.dropped(), 1U);
  add(parts[1], 1, start + IpDefragmenter::time_out + Span(2));
  EXPECT_FALSE(add(parts[2], 1, start + IpDefragmenter::time_out + Span(3)));
  EXPECT_FALSE(add(parts[3], 1, start + IpDefragmenter::time_out + Span(4)));  // its beginning was given up
}

TEST_F(Defragmenting, SurvivesTimeThatRunsBackwards) {
  add(parts[0], 1, start);
  add(parts[1], 1, start - std::chrono::hours(1));
  add(parts[2], 1, start);
  EXPECT_EQ(add(parts[3], 1, start - std::chrono::hours(9)), whole);
}

TEST_F(Defragmenting, HoldsABoundedNumberOfPacketsAndGivesUpTheOldest) {
  for (std::uint16_t id = 0; id < 1000; ++id) {
    V4 o;
    o.id = id, o.offset = 65000, o.more = true;
    add(ipv4(Bytes(400, 1), o), false, start + Span(id));
  }
  EXPECT_EQ(defragmenter.pending(), IpDefragmenter::max_packets);
  EXPECT_EQ(defragmenter.dropped(), 1000 - IpDefragmenter::max_packets);
  EXPECT_LE(defragmenter.memory(), IpDefragmenter::max_packets * 2 * 65536);
  V4 last_one;
  last_one.id = 999, last_one.offset = 64992, last_one.more = true;
  add(ipv4(Bytes(8, 1), last_one), false, start + Span(1000));  // the newest is still there
  EXPECT_EQ(defragmenter.pending(), IpDefragmenter::max_packets);
}

TEST_F(Defragmenting, HoldsBoundedMemoryUnderAPacketOfNothingButHoles) {
  for (std::size_t offset = 0; offset < 65528; offset += 16) {
    V4 o;
    o.offset = offset, o.more = true;
    add(ipv4(Bytes(8), o), false);
  }
  EXPECT_EQ(defragmenter.pending(), 1U);
  EXPECT_LE(defragmenter.memory(), 2U * 65536U + 2U * 4096U * 8U);
}

TEST_F(Defragmenting, RefusesFragmentsThatCannotBe) {
  V4 o;
  o.more = true;
  add(ipv4(Bytes(12), o), false);  // not a multiple of 8
  EXPECT_EQ(last, DefragResult::malformed);
  add(ipv4({}, o), false);
  EXPECT_EQ(last, DefragResult::malformed);
  o.more = false, o.offset = 65528;
  add(ipv4(Bytes(8), o), false);  // ends behind 65535
  EXPECT_EQ(last, DefragResult::malformed);
  add(ipv4(Bytes(7), o), false);
  EXPECT_EQ(last, DefragResult::waiting);
  EXPECT_EQ(defragmenter.pending(), 1U);
}

TEST_F(Defragmenting, GrowsToThePacketsOnceAndThenReusesItsMemory) {
  std::size_t memory = 0;
  for (std::uint16_t id = 0; id < 200; ++id) {
    for (const Part& part : parts) add(part, id);
    if (id == 0) memory = defragmenter.memory();
  }
  EXPECT_EQ(defragmenter.memory(), memory);
}

}  // namespace
}  // namespace lidard::test
