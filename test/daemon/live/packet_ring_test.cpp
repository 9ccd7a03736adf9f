// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/packet_ring.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

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

TEST(PacketRing, KeepsTheNewestThatItsMemoryHolds) {
  PacketRing ring(megabyte);
  Mill mill;
  for (std::uint64_t n = 0; n < 10'000; ++n)
    ring.add(mill.make(n, ring_start + milliseconds(n)), std::chrono::hours(1));
  std::uint64_t next = 0, kept = 0;
  EXPECT_EQ(PacketRing::read(ring.snapshot(), ring_start,
                             [&](const Packet& packet) {
                               EXPECT_TRUE(Mill::is_whole(packet));
                               EXPECT_TRUE(next == 0 || packet.missing == next) << packet.missing;
                               next = packet.missing + 1;
                               kept += packet.payload.size() + sizeof(Packet);
                             }),
            0U);
  EXPECT_EQ(next, 10'000U);
  EXPECT_LE(kept, megabyte);
  EXPECT_GT(kept, 3 * megabyte / 4);
}

TEST(PacketRing, ReadingTakesNothingOut) {
  PacketRing ring(megabyte);
  Mill mill;
  for (std::uint64_t n = 0; n < 5; ++n) {
    ring.add(mill.make(n, ring_start + milliseconds(n)), longest);
    std::uint64_t packets = 0;
    PacketRing::read(ring.snapshot(), ring_start, [&](const Packet&) { ++packets; });
    EXPECT_EQ(packets, n + 1);
  }
}

TEST(PacketRing, SortsWhatSeveralThreadsAddLate) {
  PacketRing ring(10 * megabyte);
  Mill mill;
  for (std::uint64_t n = 0; n < 1000; ++n) {
    ring.add(mill.make(2 * n, ring_start + milliseconds(2 * n)), longest);
    if (n >= 300) ring.add(mill.make(2 * n - 599, ring_start + milliseconds(2 * n - 599)), longest);
  }
  Stamp last{};
  PacketRing::read(ring.snapshot(), ring_start + milliseconds(500), [&](const Packet& packet) {
    EXPECT_GE(packet.arrival, std::max(last, ring_start + milliseconds(500)));
    last = packet.arrival;
  });
  EXPECT_EQ(last, ring_start + milliseconds(1998));
}

TEST(PacketRing, HandsOutOnlyWholePacketsWhileOthersAreAdded) {
  PacketRing ring(8 * megabyte);
  std::mutex mutex;
  std::atomic<bool> stop{false};
  std::atomic<std::uint64_t> added{0};
  std::thread owner([&] {
    Mill mill;
    for (std::uint64_t n = 0; !stop; added = ++n) {
      std::this_thread::yield();
      const std::lock_guard lock(mutex);
      ring.add(mill.make(n, ring_start + Span(n)), longest);
    }
  });
  std::uint64_t all_lost = 0;
  for (int round = 0; round < 5; ++round) {
    const std::uint64_t before = added;
    while (added < before + 10'000) std::this_thread::yield();
    std::unique_lock lock(mutex);
    const PacketRing::Snapshot snapshot = ring.snapshot();
    const std::uint64_t end = added + 1;
    lock.unlock();
    std::uint64_t next = 0;
    all_lost += PacketRing::read(snapshot, ring_start, [&](const Packet& packet) {
      EXPECT_TRUE(Mill::is_whole(packet));
      EXPECT_GE(packet.missing, next);
      EXPECT_LE(packet.missing, end) << "of the instant of the snapshot";
      next = packet.missing + 1;
    });
    EXPECT_GT(next, 0U);
  }
  stop = true;
  owner.join();
  std::printf("%lu packets added, %lu reused before they were read\n",
              static_cast<unsigned long>(added.load()), static_cast<unsigned long>(all_lost));
}

TEST(PacketRing, CountsWhatWasReusedBeforeItWasReadAndBeginsConnectionsAnew) {
  PacketRing ring(20 * megabyte);
  Mill mill;
  mill.packet.transport = Transport::tcp;
  std::uint64_t n = 0;
  const auto add = [&](std::uint64_t count) {
    for (; count > 0; --count, ++n)
      ring.add(mill.make(n, ring_start + milliseconds(n)), std::chrono::hours(1));
  };
  add(30'000);
  const PacketRing::Snapshot snapshot = ring.snapshot();
  // A disk that stands still as soon as it gets something: half of the ring is reused meanwhile.
  std::uint64_t first = 0, packets = 0;
  std::vector<std::uint64_t> starts;
  const std::uint64_t lost = PacketRing::read(snapshot, ring_start, [&](const Packet& packet) {
    if (packets++ == 0) {
      first = packet.missing;
      add(9000);
    }
    if (packet.stream_start) starts.push_back(packet.missing - first - packets + 1);
  });
  EXPECT_GT(lost, 1000U);
  EXPECT_EQ(first + packets + lost, 30'000U);
  EXPECT_EQ(starts, std::vector<std::uint64_t>{lost}) << "once, right behind the gap";
}

TEST(PacketRing, WhatIsReusedBeforeTheReaderBeginsIsNoGap) {
  PacketRing ring(megabyte);
  Mill mill;
  for (std::uint64_t n = 0; n < 2000; ++n) ring.add(mill.make(n, ring_start + milliseconds(n)), longest);
  const PacketRing::Snapshot snapshot = ring.snapshot();
  for (std::uint64_t n = 0; n < 300; ++n) ring.add(mill.make(n, ring_start + milliseconds(n)), longest);
  std::uint64_t first = 0, packets = 0;
  const std::uint64_t lost = PacketRing::read(snapshot, ring_start, [&](const Packet& packet) {
    if (packets++ == 0) first = packet.missing;
  });
  EXPECT_EQ(lost, 0U);
  EXPECT_GT(packets, 100U);
  EXPECT_EQ(first + packets, 2000U);
}

TEST(PacketRing, TouchesNoMoreMemoryThanTheTimeNeeds) {
  const auto resident = [] {
    std::FILE* const file = std::fopen("/proc/self/statm", "r");
    unsigned long pages = 0, all = 0;
    EXPECT_EQ(std::fscanf(file, "%lu %lu", &all, &pages), 2);
    std::fclose(file);
    return pages * 4096;
  };
  const std::size_t before = resident();
  PacketRing ring(200 * megabyte);
  Mill mill;
  // A minute of 10 packets a second, for an hour.
  for (std::uint64_t n = 0; n < 36'000; ++n)
    ring.add(mill.make(n, ring_start + milliseconds(100 * n)), longest);
  EXPECT_LT(resident() - before, 4 * megabyte);
  std::uint64_t packets = 0;
  PacketRing::read(ring.snapshot(), ring_start + milliseconds(3'599'900) - longest,
                   [&](const Packet&) { ++packets; });
  EXPECT_EQ(packets, 601U);
}

}  // namespace
}  // namespace lidard
