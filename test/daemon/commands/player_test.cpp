// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/commands/player.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <vector>

#include "test/drivers/capture/pcap_testing.h"
#include "test/support/pipeline_bench.h"

namespace lidard::test {
namespace {

/// What is played of a capture with datagrams at these times, s.
struct Played {
  explicit Played(const std::vector<double>& times, ReplayOptions options = {}) {
    PcapBytes bytes;
    for (const double at : times) bytes.add(ethernet(ipv4(udp({1, 2, 3}))), at);
    const MemoryFile file(bytes.bytes);
    MergedCapture capture({file.path()});
    PipelineBench bench("sensors: {a: {model: velodyne_vlp16}}\n");
    Player player(options, capture, bench.pipeline);
    const auto begin = std::chrono::steady_clock::now();
    player.on_time = [&](Stamp stamp) { shown.push_back(seconds(stamp - Stamp{})); };
    player.play([] { return false; });
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
  ReplayOptions fast;
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

}  // namespace
}  // namespace lidard::test
