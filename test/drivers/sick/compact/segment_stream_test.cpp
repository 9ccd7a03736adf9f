// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <random>

#include "test/drivers/sick/compact/segment_bench.h"

namespace lidard::sick {
namespace {

using namespace lidard::test;

/// Six turns as one stream of bytes, and where each telegram ends.
struct Stream {
  Stream() {
    const SegmentBench bench("sick_lrs4000");
    for (std::uint64_t f = 0; f < 6; ++f) {
      for (int i = 0; i < SegmentBench::segments; ++i) {
        const auto telegram = bench.encode(bench.segment(f, i));
        bytes.insert(bytes.end(), telegram.begin(), telegram.end());
        ends.push_back(bytes.size());
      }
    }
  }
  std::vector<std::uint8_t> bytes;
  std::vector<std::size_t> ends;
};

void feed(SegmentBench& bench, const std::vector<std::uint8_t>& bytes, std::size_t begin, std::size_t end,
          bool start = false, std::uint64_t missing = 0) {
  Packet packet;
  packet.transport = Transport::tcp;
  packet.payload = ByteView(bytes.data() + begin, end - begin);
  packet.stream_start = start;
  packet.missing = missing;
  packet.arrival = bench.epoch + std::chrono::microseconds(static_cast<std::int64_t>(8 * end));
  bench.driver->receive(packet, bench);
}

TEST(SegmentStream, AnyCutsOfTheStreamGiveTheSameScans) {
  const Stream stream;
  std::vector<PlanarScan> whole;
  for (unsigned seed = 0; seed < 40; ++seed) {
    SegmentBench bench("sick_lrs4000");
    std::mt19937 random(seed);
    const std::size_t longest = seed == 0 ? 1 : seed == 1 ? 1'000'000 : 1 + random() % 3000;
    for (std::size_t at = 0; at < stream.bytes.size();) {
      const std::size_t step = std::min(stream.bytes.size() - at, seed == 0 ? 1 : 1 + random() % longest);
      feed(bench, stream.bytes, at, at + step, at == 0);
      at += step;
    }
    ASSERT_EQ(bench.scans.size(), 5U) << seed;
    EXPECT_EQ(bench.driver->counters().packets, 60U);
    EXPECT_EQ(bench.driver->counters().rejected_total(), 0U);
    if (whole.empty()) whole = bench.scans;
    for (std::size_t i = 0; i < whole.size(); ++i) EXPECT_EQ(bench.scans[i].ranges, whole[i].ranges);
  }
}

TEST(SegmentStream, JoinedAtAnyByteItFindsTheNextTelegram) {
  const Stream stream;
  for (std::size_t join = 0; join <= stream.ends[0]; join += 1) {
    SegmentBench bench("sick_lrs4000");
    feed(bench, stream.bytes, join, stream.bytes.size(), true);
    const std::size_t expected = join == 0 ? 60 : 59;
    ASSERT_EQ(bench.driver->counters().packets, expected) << join;
    EXPECT_EQ(bench.driver->counters().rejected_total(), 0U) << join;
    EXPECT_EQ(bench.scans.size(), 5U) << join;
  }
}

TEST(SegmentStream, AHoleCostsItsTelegramsOnly) {
  const Stream stream;
  for (unsigned seed = 0; seed < 60; ++seed) {
    SegmentBench bench("sick_lrs4000");
    std::mt19937 random(seed);
    const std::size_t begin = stream.ends[35] + random() % 900, hole = 1 + random() % 2000;
    feed(bench, stream.bytes, 0, begin, true);
    feed(bench, stream.bytes, begin + hole, stream.bytes.size(), false, hole);
    std::size_t intact = 0;
    for (std::size_t i = 0; i < stream.ends.size(); ++i) {
      const std::size_t from = i == 0 ? 0 : stream.ends[i - 1];
      if (stream.ends[i] <= begin || from >= begin + hole) ++intact;
    }
    EXPECT_EQ(bench.driver->counters().packets, intact) << seed;
    EXPECT_EQ(bench.driver->counters().lost_packets, 60 - intact) << seed;
    EXPECT_EQ(bench.scans.size(), 5U) << seed;
  }
}

TEST(SegmentStream, ADamagedTelegramCostsItselfOnly) {
  Stream stream;
  stream.bytes[stream.ends[35] + 300] ^= 0x10U;
  SegmentBench bench("sick_lrs4000");
  feed(bench, stream.bytes, 0, stream.bytes.size(), true);
  EXPECT_EQ(bench.driver->counters().packets, 59U);
  EXPECT_EQ(bench.driver->counters().rejected[static_cast<std::size_t>(Reject::checksum)], 1U);
  EXPECT_EQ(bench.driver->counters().lost_packets, 1U);
  EXPECT_EQ(bench.scans.size(), 5U);
}

TEST(SegmentStream, ANewConnectionForgetsHalfATelegram) {
  const Stream stream;
  SegmentBench bench("sick_lrs4000");
  feed(bench, stream.bytes, 0, stream.ends[24] + 77, true);
  bench.driver->disconnected();
  EXPECT_EQ(bench.driver->counters().incomplete, 1U);
  feed(bench, stream.bytes, stream.ends[25], stream.bytes.size(), true);
  EXPECT_EQ(bench.driver->counters().packets, 59U);
  EXPECT_EQ(bench.driver->counters().rejected_total(), 0U);
}

}  // namespace
}  // namespace lidard::sick
