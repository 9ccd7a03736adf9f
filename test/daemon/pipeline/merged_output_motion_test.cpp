// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// The instant of a merged scan where poses of the vehicle are known, late or missing.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "test/daemon/pipeline/merged_output_bench.h"

namespace lidard {
namespace {

using namespace test::merged;
using test::bench_begin;
using test::PipelineBench;
using test::round_scan;
using testing::HasSubstr;
using testing::MatchesRegex;

TEST(MergedScanMaker, InstantIsTheNewestRayThatHasAPoseButNoneBeforeTheFirstRays) {
  // The sweeps last from 920 and 927 to 1000 and 1007.
  const struct {
    double newest_pose, instant;
  } cases[] = {{1100, 1007}, {1007, 1007}, {990, 990}, {960, 960}, {930, 930}, {920, 927}, {900, 927}};
  for (const auto& one : cases) {
    PipelineBench bench(two_sources("", "odometry_topic: /odom"));
    poses_until(bench, ms(one.newest_pose), bench_begin + ms(990));
    sweep(bench, "a", ms(1000));
    sweep(bench, "b", ms(1007));
    ASSERT_EQ(bench.sink.count("m"), 1U) << one.newest_pose;
    EXPECT_NEAR(seconds(bench.sink.scans["m"][0].stamp - bench_begin), one.instant / 1000, 2e-6)
        << "newest pose " << one.newest_pose;
  }
}

TEST(MergedScanMaker, OfPolicyRateIsOfTheInstantItIsMadeAtWhereAPoseIsKnown) {
  PipelineBench bench(two_sources("rate: 10", "odometry_topic: /odom"));
  sweep(bench, "a", ms(900));
  sweep(bench, "b", ms(900));
  sweep(bench, "a", ms(990));
  sweep(bench, "b", ms(995));
  const std::size_t before = bench.sink.count("m");
  poses_until(bench, ms(990), bench_begin + ms(995));
  bench.pipeline.pose_message(bench_begin + ms(999.999), make_pose({0, 0, 0}, {0, 0, 0.3}), "",
                              bench_begin + ms(999.999));
  bench.pipeline.tick(bench_begin + ms(1000));
  ASSERT_EQ(bench.sink.count("m"), before + 1);
  EXPECT_EQ(bench.sink.released["m"].back(), bench_begin + ms(1000));
  expect_near(bench.sink.scans["m"].back().stamp, bench_begin + ms(1000));
}

TEST(MergedScanMaker, WaitsForPosesUntilItsDeadlineAndThenGoesOnWithoutThem) {
  PipelineBench bench(two_sources("on_missing_motion: wait, deadline: 0.05", "odometry_topic: /odom"));
  poses_until(bench, ms(850), bench_begin + ms(850));
  sweep(bench, "a", ms(1000));
  sweep(bench, "b", ms(1000));
  EXPECT_EQ(bench.sink.count("m"), 0U);
  bench.pipeline.tick(bench_begin + ms(1049));
  EXPECT_EQ(bench.sink.count("m"), 0U);
  EXPECT_EQ(bench.pipeline.next_event(), bench_begin + ms(1050));
  bench.pipeline.tick(bench_begin + ms(1050));
  EXPECT_EQ(bench.sink.count("m"), 1U);
  const Stamp now = bench_begin + ms(1050);
  EXPECT_EQ(bench.value("merged m", "Not deskewed", now), "1");
  EXPECT_EQ(bench.value("merged m", "Motion", now), "not deskewed: poses of the sweeps' time are missing");
  EXPECT_EQ(bench.item("merged m", now).health, Health::warn);

  // The next sweeps' poses come in time.
  sweep(bench, "a", ms(1100));
  sweep(bench, "b", ms(1100));
  EXPECT_EQ(bench.sink.count("m"), 1U);
  poses_until(bench, ms(1110), bench_begin + ms(1120));
  EXPECT_EQ(bench.sink.count("m"), 2U);
  EXPECT_EQ(bench.sink.released["m"].back(), bench_begin + ms(1120));
  EXPECT_EQ(bench.value("merged m", "Not deskewed", bench_begin + ms(1120)), "1");
  EXPECT_THAT(bench.value("merged m", "Motion", bench_begin + ms(1120)), testing::StartsWith("deskewed"));
}

TEST(MergedScanMaker, AClockThatIsSetBackDoesNotProlongTheWaitForPoses) {
  PipelineBench bench(two_sources("on_missing_motion: wait, deadline: 0.05", "odometry_topic: /odom"));
  sweep(bench, "a", ms(1000));
  sweep(bench, "b", ms(1000));
  EXPECT_EQ(bench.sink.count("m"), 0U);
  poses_until(bench, ms(100), bench_begin + ms(990));
  EXPECT_EQ(bench.sink.count("m"), 1U) << "no longer than until the clock is seen to be set back";
}

TEST(MergedScanMaker, StampsOfOneSourceThatJumpLeaveNoEventInThePast) {
  for (const double jump_s : {-100.0, -2.0, 2.0, 100.0}) {
    for (const char* keys : {"on_missing_motion: static", "on_missing_motion: wait, deadline: 0.05",
                             "on_missing_motion: drop", "on_missing_motion: wait, rate: 10"}) {
      SCOPED_TRACE(std::string(keys) + " " + std::to_string(jump_s));
      PipelineBench bench(two_sources(keys, "odometry_topic: /odom"));
      poses_until(bench, ms(930), bench_begin + ms(990));
      sweep(bench, "a", ms(1000));
      sweep(bench, "b", ms(1000));
      const Stamp jumped = bench_begin + ms(1010) + span_from_seconds(jump_s);
      bench.give("a", round_scan("a", jumped, 5, 361, sweep_time), bench_begin + ms(1020));
      for (double at = 1020; at <= 1400; at += 10) {
        bench.pipeline.tick(bench_begin + ms(at));
        const auto event = bench.pipeline.next_event();
        ASSERT_TRUE(!event || *event > bench_begin + ms(at)) << at;
      }
    }
  }
}

TEST(MergedScanMaker, PosesInAnotherFrameAfterAReloadDoNotContinueThoseBefore) {
  PipelineBench bench(two_sources("", "odometry_topic: /odom"));
  poses_until(bench, ms(1100), bench_begin + ms(990));
  bench.pipeline.configure(parse_config(two_sources("", "odometry_topic: /map_pose"), "bench"));
  sweep(bench, "a", ms(1000));
  sweep(bench, "b", ms(1000));
  EXPECT_EQ(bench.value("merged m", "Motion", bench_begin + ms(1000)), "no poses yet");
}

TEST(MergedScanMaker, PatienceForPosesBeginsAnewWithEachOutput) {
  PipelineBench bench(two_sources("on_missing_motion: wait, deadline: 0.05", "odometry_topic: /odom"));
  for (const double at : {1000.0, 1100.0, 1200.0}) {
    const std::size_t before = bench.sink.count("m");
    sweep(bench, "a", ms(at));
    sweep(bench, "b", ms(at));
    bench.pipeline.tick(bench_begin + ms(at + 40));
    EXPECT_EQ(bench.sink.count("m"), before) << at;
    bench.pipeline.tick(bench_begin + ms(at + 60));
    EXPECT_EQ(bench.sink.count("m"), before + 1) << at;
  }
}

TEST(MergedScanMaker, CountsOutputsThatAreLeftOutForWantOfPoses) {
  PipelineBench bench(two_sources("on_missing_motion: drop", "odometry_topic: /odom"));
  for (double at = 100; at <= 500; at += 100) {
    sweep(bench, "a", ms(at));
    sweep(bench, "b", ms(at));
  }
  const Stamp now = bench_begin + ms(500);
  EXPECT_EQ(bench.sink.count("m"), 0U);
  EXPECT_EQ(bench.value("merged m", "Left out without poses", now), "5");
  EXPECT_EQ(bench.value("merged m", "Motion", now), "no poses yet");
  EXPECT_EQ(why_missing(bench.pipeline, "m"),
            "no output: on_missing_motion: drop, and poses of the vehicle are missing; see that odometry is "
            "published");
}

}  // namespace
}  // namespace lidard
