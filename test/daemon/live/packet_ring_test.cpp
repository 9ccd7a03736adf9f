// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/packet_ring.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "test/support/allocations.h"

namespace lidard {
namespace {

using std::chrono::milliseconds;

constexpr Stamp ring_start{1'700'000'000'000'000'000};
constexpr Span longest = std::chrono::seconds(60);
constexpr std::size_t megabyte = 1'000'000;

/// Every byte of packet n is n modulo 251, and its length depends on n.
struct Mill {
  std::string bytes;
  Packet packet;

  const Packet& make(std::uint64_t n, Stamp at) {
    bytes.assign(500 + n * 37 % 1000, static_cast<char>(n % 251));
    packet.payload = ByteView(bytes);
    packet.arrival = at;
    packet.missing = n;
    return packet;
  }
  static bool is_whole(const Packet& packet) {
    const std::uint64_t n = packet.missing;
    const auto expected = static_cast<std::uint8_t>(n % 251);
    return packet.payload.size() == 500 + n * 37 % 1000 &&
           std::all_of(packet.payload.begin(), packet.payload.end(),
                       [&](std::uint8_t byte) { return byte == expected; });
  }
};

/// The numbers of the packets, which are checked.
std::vector<std::uint64_t> numbers(PacketRing::Snapshot snapshot, Stamp since) {
  std::vector<std::uint64_t> all;
  PacketRing::read(std::move(snapshot), since, [&](const Packet& packet) {
    EXPECT_TRUE(Mill::is_whole(packet));
    all.push_back(packet.missing);
  });
  return all;
}

TEST(PacketRing, KeepsTheNewestThatItsMemoryHolds) {
  PacketRing ring(megabyte);
  Mill mill;
  for (std::uint64_t n = 0; n < 10'000; ++n)
    ring.add(mill.make(n, ring_start + milliseconds(n)), std::chrono::hours(1));
  std::uint64_t kept = 0, next = 0;
  PacketRing::read(ring.snapshot(), ring_start, [&](const Packet& packet) {
    EXPECT_TRUE(Mill::is_whole(packet));
    EXPECT_TRUE(next == 0 || packet.missing == next) << packet.missing;
    next = packet.missing + 1;
    kept += packet.payload.size() + sizeof(Packet);
  });
  EXPECT_EQ(next, 10'000U);
  EXPECT_LE(kept, megabyte);
  EXPECT_GT(kept, 3 * megabyte / 4);
}

TEST(PacketRing, ReadingTakesNothingOut) {
  PacketRing ring(megabyte);
  Mill mill;
  for (std::uint64_t n = 0; n < 5; ++n) {
    ring.add(mill.make(n, ring_start + milliseconds(n)), longest);
    EXPECT_EQ(numbers(ring.snapshot(), ring_start).size(), n + 1);
  }
}

TEST(PacketRing, SortsWhatSeveralThreadsAddLate) {
  PacketRing ring(10 * megabyte);
  Mill mill;
  for (std::uint64_t n = 0; n < 1000; ++n) {
    ring.add(mill.make(2 * n, ring_start + milliseconds(2 * n)), longest);
    if (n >= 300) ring.add(mill.make(2 * n - 599, ring_start + milliseconds(2 * n - 599)), longest);
  }
  const auto sorted = numbers(ring.snapshot(), ring_start + milliseconds(500));
  EXPECT_TRUE(std::is_sorted(sorted.begin(), sorted.end()));
  EXPECT_EQ(sorted.front(), 500U);
  EXPECT_EQ(sorted.back(), 1998U);
}

TEST(PacketRing, ASnapshotStaysAsItWasWhileTheRingGoesRoundAndItsMemoryIsReusedAfterIt) {
  PacketRing ring(megabyte);
  Mill mill;
  const auto add = [&](std::uint64_t from) {
    for (std::uint64_t n = from; n < from + 3000; ++n)
      ring.add(mill.make(n, ring_start + milliseconds(n)), longest);
  };
  add(0);
  PacketRing::Snapshot snapshot = ring.snapshot();
  add(3000);
  const std::size_t before = test::resident_bytes();
  const auto read = numbers(std::move(snapshot), ring_start);
  ASSERT_GT(read.size(), 100U);
  EXPECT_EQ(read.back(), 2999U);
  add(6000);
  EXPECT_LT(test::resident_bytes(), before + megabyte);
}

TEST(PacketRing, TouchesNoMoreMemoryThanTheTimeNeeds) {
  [[maybe_unused]] const std::size_t before = test::resident_bytes();
  PacketRing ring(200 * megabyte);
  Mill mill;
  // A minute of 10 packets a second, for an hour.
  for (std::uint64_t n = 0; n < 36'000; ++n)
    ring.add(mill.make(n, ring_start + milliseconds(100 * n)), longest);
#ifndef __SANITIZE_THREAD__  // which remembers accesses in memory of its own
  EXPECT_LT(test::resident_bytes() - before, 4 * megabyte);
#endif
  EXPECT_EQ(numbers(ring.snapshot(), ring_start + milliseconds(3'599'900) - longest).size(), 601U);
}

}  // namespace
}  // namespace lidard
