// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/offline/player.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <vector>

#include "test/drivers/capture/pcap_testing.h"
#include "test/support/pipeline_bench.h"

namespace lidard::test {
namespace {

/// A capture with datagrams at these times, s.
PcapBytes datagrams(const std::vector<double>& times) {
  PcapBytes bytes;
  for (const double at : times) bytes.add(ethernet(ipv4(udp({1, 2, 3}))), at);
  return bytes;
}

/// What is played of a capture, up to `most` packets.
struct Played {
  explicit Played(const std::vector<double>& times, PlayOptions options = {}, std::size_t most = 100)
      : Played(datagrams(times), options, most) {}
  explicit Played(const PcapBytes& bytes, PlayOptions options = {}, std::size_t most = 100) {
    const MemoryFile file(bytes.bytes);
    MergedCapture capture({file.path()});
    PipelineBench bench("sensors: {a: {model: velodyne_vlp16}}\n");
    Player player(options, capture, bench.pipeline);
    const auto begin = std::chrono::steady_clock::now();
    player.on_time = [&](Stamp stamp) { shown.push_back(seconds(stamp - Stamp{})); };
    player.play([&] { return shown.size() >= most; });
    wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    skipped = player.skipped();
    played_s = player.played_s();
  }
  std::vector<double> shown;
  double wall_s = 0, played_s = 0;
  std::uint64_t skipped = 0;
};

TEST(Player, FollowsACaptureWhoseClockWasSetAtItsPace) {
  for (const double step : {-3600.0, 3600.0, 1.7e9}) {
    const Played got({5000, 5000.1, 5000.2, 5000.2 + step, 5000.3 + step, 5000.4 + step});
    EXPECT_EQ(got.skipped, 0U) << step;
    ASSERT_EQ(got.shown.size(), 6U) << step;
    EXPECT_NEAR(got.shown.back(), 5000.4 + step, 1e-6);
    EXPECT_NEAR(got.played_s, 0.4, 1e-6) << step;
    EXPECT_GE(got.wall_s, 0.39) << step;
    EXPECT_LT(got.wall_s, 60) << step;
  }
}

TEST(Player, PlaysPacketsThatAreOlderThanTheFirstOneAndItsClockStandsStillForThem) {
  PlayOptions fast;
  fast.rate = 0;
  const Played got({10, 9.999999, 10.1, 7.2, 10.2}, fast);
  EXPECT_EQ(got.skipped, 0U);
  ASSERT_EQ(got.shown.size(), 5U);
  EXPECT_TRUE(std::is_sorted(got.shown.begin(), got.shown.end()));
  EXPECT_NEAR(got.shown.back(), 10.2, 1e-6);
  fast.start = 0.05;
  const Played part({10, 9.999999, 10.1, 7.2, 10.2}, fast);
  EXPECT_EQ(part.skipped, 2U);
  EXPECT_EQ(part.shown.size(), 3U);
}

TEST(Player, RepeatsACaptureWhoseClockWasSetWithoutTheStep) {
  for (const double step : {-3600.0, 3600.0, -5.0}) {
    for (const bool restamp : {false, true}) {
      PlayOptions loop;
      loop.loop = true;
      loop.restamp = restamp;
      loop.rate = 10;
      const Played got({5000, 5000.1, 5000.2, 5000.2 + step, 5000.3 + step, 5000.4 + step}, loop, 18);
      ASSERT_EQ(got.shown.size(), 18U);
      for (std::size_t i = 0; i < 18; ++i) {
        const double round = 0.5 * static_cast<double>(i / 6),
                     at = static_cast<double>(i % 6 - i % 6 / 3) / 10;
        EXPECT_NEAR(got.shown[i] - got.shown[0], round + at, 1e-5) << step << ", packet " << i;
      }
      EXPECT_NEAR(got.played_s, 1.4, 1e-5) << step;
    }
  }
}

TEST(Player, MeasuresStartAndDurationWithoutTheStepsOfTheClock) {
  for (const double step : {-3600.0, 3600.0, -5.0}) {
    PlayOptions part;
    part.start = 0.15;
    part.duration = 0.2;
    const Played got({5000, 5000.1, 5000.1 + step, 5000.2 + step, 5000.3 + step, 5000.4 + step}, part);
    EXPECT_EQ(got.skipped, 3U) << step;
    ASSERT_EQ(got.shown.size(), 2U) << step;
    EXPECT_NEAR(got.shown[0], 5000.2 + step, 1e-5);
    EXPECT_NEAR(got.shown[1], 5000.3 + step, 1e-5);
  }
}

TEST(Player, PlaysPacketsOfAnotherClockAmongTheOthers) {
  for (const double ahead : {20.0, 50.0, -20.0, 3600.0, -3600.0}) {
    for (const bool all : {false, true}) {
      std::vector<double> times(12);
      for (std::size_t i = 0; i < 12; ++i)
        times[i] = 5000 + 0.1 * static_cast<double>(i) + (i == 5 || (all && i % 2 == 1) ? ahead : 0);
      PlayOptions part;
      part.start = 0.35;
      part.rate = 10;
      const Played got(times, part);
      EXPECT_EQ(got.skipped, 4U) << ahead;
      ASSERT_EQ(got.shown.size(), 8U) << ahead;
      for (std::size_t i = 0; i < 8; ++i)
        EXPECT_NEAR(got.shown[i], 5000.4 + 0.1 * static_cast<double>(i), 0.101) << ahead << ", packet " << i;
      EXPECT_TRUE(std::is_sorted(got.shown.begin(), got.shown.end())) << ahead;
      EXPECT_LT(got.wall_s, 0.9) << ahead;
    }
  }
}

TEST(Player, WaitsThroughASilence) {
  PlayOptions quick;
  quick.rate = 100;
  const Played got({5000, 5000.1, 5020, 5020.1, 5021}, quick);
  EXPECT_NEAR(got.played_s, 21, 1e-5);
  EXPECT_GE(got.wall_s, 0.2);
}

TEST(Player, ItsClockStandsStillForChunksThatWaitedBehindAHole) {
  PcapBytes bytes = datagrams({1});
  std::uint32_t sequence = 1;
  for (const double at : {1.1, 1.5, 2.0, 2.6}) {
    bytes.add(ethernet(ipv4(tcp({'x'}, sequence, 2112, 40000), of_tcp())), at);
    sequence += sequence == 1 ? 9 : 1;
  }
  for (const double at : {4.7, 4.8, 4.9}) bytes.add(ethernet(ipv4(udp({1, 2, 3}))), at);
  PlayOptions fast;
  fast.rate = 0;
  const Played got(bytes, fast);
  EXPECT_EQ(got.shown.size(), 8U);
  EXPECT_TRUE(std::is_sorted(got.shown.begin(), got.shown.end()));
}

}  // namespace
}  // namespace lidard::test
