// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// A merged scan beside its beams: its stamp, its figures in /diagnostics, and what a change of its settings
// leaves as it was.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "daemon/pipeline/merging_maker.h"
#include "test/daemon/pipeline/merged_output_bench.h"

namespace lidard {
namespace {

using namespace test::merged;
using test::bench_begin;
using test::PipelineBench;
using test::round_scan;
using testing::HasSubstr;
using testing::MatchesRegex;

TEST(MergedScanMaker, AgeOfASourceCountsFromItsLastRay) {
  PipelineBench bench(two_sources("deadline: 0.01"));
  for (double at = 100; at <= 1000; at += 100) {
    sweep(bench, "a", ms(at));
    sweep(bench, "b", ms(at + 7));
  }
  const Stamp now = bench_begin + ms(1030);
  EXPECT_EQ(bench.value("merged m", "Source a", now), "ok, 10.0 Hz, age 30 ms");
  EXPECT_EQ(bench.value("merged m", "Source b", now), "ok, 10.0 Hz, age 23 ms");
  // The instant of an output is the first ray of its newest sweep; it came out with the last one.
  expect_near(bench.sink.scans["m"].back().stamp, bench_begin + ms(1007) - sweep_time);
  EXPECT_EQ(bench.sink.released["m"].back(), bench_begin + ms(1007));
}

TEST(MergedScanMaker, CountsReturnsWhereFreeSpaceIsComputed) {
  for (const char* profile : {"flatten", "strict"}) {
    const PipelineBench bench(two_sources(std::string("profile: ") + profile));
    const bool flat = profile == std::string("flatten");
    for (const char* key : {"Returns on the vehicle", "Returns from behind the vehicle", "Mixed pixels"})
      EXPECT_EQ(bench.value("merged m", key, bench_begin), flat ? "no such key" : "0") << profile;
  }
}

TEST(MergedScanMaker, StampDoesNotDependOnTheOrderOfTheSources) {
  for (const bool a_first : {false, true}) {
    PipelineBench bench(two_sources(""));
    sweep(bench, a_first ? "a" : "b", ms(100));
    sweep(bench, a_first ? "b" : "a", ms(112));
    ASSERT_EQ(bench.sink.count("m"), 1U);
    expect_near(bench.sink.scans["m"].back().stamp, bench_begin + ms(112) - sweep_time);
  }
}

TEST(MergedScanMaker, AgeOfStampsOfAnotherClockCountsFromTheArrival) {
  PipelineBench bench(two_sources("deadline: 0.01"));
  const Span simulated = std::chrono::hours(200'000);
  bench.pipeline.set_message_clock(-simulated);
  for (double at = 100; at <= 1000; at += 100) {
    for (const char* source : {"a", "b"})
      bench.give(source, round_scan(source, bench_begin + ms(at) - simulated, 5, 361, sweep_time),
                 bench_begin + ms(at));
  }
  const Stamp now = bench_begin + ms(1030);
  EXPECT_EQ(bench.value("merged m", "Source a", now), "ok, 10.0 Hz, age 30 ms");
  EXPECT_EQ(bench.sink.count("m"), 10U);
}

TEST(MergedScanMaker, StatusTopicNeverSaysMoreThanRangeMax) {
  PipelineBench bench(two_sources("profile: strict, status_topic: known"));
  sweep(bench, "a", ms(100), 28);
  sweep(bench, "b", ms(100), 28);
  ASSERT_EQ(bench.sink.count("known"), 1U);
  const PlanarScan& known = bench.sink.scans["known"][0];
  EXPECT_EQ(known.range_max, 20);
  EXPECT_EQ(known.stamp, bench.sink.scans["m"][0].stamp);
  EXPECT_EQ(known.frame_id, "base_link");
  for (std::size_t i = 0; i < known.beams; ++i) EXPECT_LE(known.ranges[i], 20) << i;
  EXPECT_GT(std::count(known.ranges.begin(), known.ranges.end(), 20), 350) << "nearly all of it is free";
}

OutputScanConfig changed(const PipelineBench& bench, std::size_t beams) {
  OutputScanConfig wanted = bench.config.merged_scans[0].output;
  wanted.grid.beams = beams;
  return wanted;
}

TEST(MergedScanMaker, AfterAChangeWaitsForEverySourceThatIsWell) {
  PipelineBench bench(two_sources(""));
  for (double at = 100; at <= 500; at += 100) {
    sweep(bench, "a", ms(at));
    sweep(bench, "b", ms(at + 5));
  }
  EXPECT_EQ(bench.sink.count("m"), 5U);
  ASSERT_EQ(bench.pipeline.set_scan({MakerId::Kind::merged, "m"}, changed(bench, 180)), "");
  sweep(bench, "a", ms(600));
  bench.pipeline.tick(bench_begin + ms(601));
  EXPECT_EQ(bench.sink.count("m"), 5U) << "what b sees would be missing";
  sweep(bench, "b", ms(605));
  EXPECT_EQ(bench.sink.count("m"), 6U);
  EXPECT_EQ(bench.sink.scans["m"].back().beams, 180U);
  const Stamp now = bench_begin + ms(607);
  EXPECT_EQ(bench.value("merged m", "Published", now), "6") << "the count goes on";
  EXPECT_EQ(bench.value("merged m", "Source b", now), "ok, 10.0 Hz, age 2 ms") << "and what is known of it";
}

TEST(MergedScanMaker, AfterAChangeDoesNotWaitForASourceThatIsLost) {
  PipelineBench bench(two_sources(""));
  sweep(bench, "a", ms(100));
  sweep(bench, "b", ms(100));
  for (double at = 200; at <= 1000; at += 100) sweep(bench, "a", ms(at));
  bench.pipeline.tick(bench_begin + ms(1050));
  const std::size_t before = bench.sink.count("m");
  ASSERT_EQ(bench.pipeline.set_scan({MakerId::Kind::merged, "m"}, changed(bench, 180)), "");
  sweep(bench, "a", ms(1100));
  EXPECT_EQ(bench.sink.count("m"), before + 1);
}

TEST(MergedScanMaker, StampsDoNotGoBackOverAChange) {
  PipelineBench bench(two_sources(""));
  sweep(bench, "a", ms(500));
  sweep(bench, "b", ms(500));
  const Stamp before = bench.sink.scans["m"].back().stamp;
  ASSERT_EQ(bench.pipeline.set_scan({MakerId::Kind::merged, "m"}, changed(bench, 180)), "");
  // Both scanners' stamps go 20 ms back, as after a correction of their clocks.
  for (const char* source : {"a", "b"})
    bench.give(source, round_scan(source, bench_begin + ms(400), 5, 361, sweep_time), bench_begin + ms(600));
  EXPECT_EQ(bench.sink.count("m"), 1U) << "nothing newer is known";
  sweep(bench, "a", ms(610));
  sweep(bench, "b", ms(610));
  ASSERT_EQ(bench.sink.count("m"), 2U);
  EXPECT_GT(bench.sink.scans["m"].back().stamp, before);
}

TEST(MergedScanMaker, AChangeIsRefusedForAGridThatIsWrongOrAnOutputThatIsNotThere) {
  PipelineBench bench(two_sources(""));
  OutputScanConfig wanted = changed(bench, 180);
  EXPECT_THAT(bench.pipeline.set_scan({MakerId::Kind::virtual_group, "m"}, wanted),
              HasSubstr("no output named m"));
  wanted.grid.angle_max = wanted.grid.angle_min - 1;
  EXPECT_THAT(bench.pipeline.set_scan({MakerId::Kind::merged, "m"}, wanted),
              HasSubstr("expected angle_min < angle_max"));
  sweep(bench, "a", ms(100));
  sweep(bench, "b", ms(100));
  EXPECT_EQ(bench.sink.scans["m"].at(0).beams, bench.config.merged_scans[0].output.grid.beams);
}

TEST(MergedScanMaker, WhatShowsNoNewerInstantIsNotPublishedAgainButCounted) {
  PipelineBench bench(two_sources(""));
  for (double at = 100; at <= 1000; at += 100) {
    sweep(bench, "a", ms(at));
    sweep(bench, "b", ms(at + 5));
  }
  const std::size_t before = bench.sink.count("m");
  // Both are late, a by more: it is overdue first, and without it there is what b showed before.
  for (double at = 1005; at < 1250; at += 5) bench.pipeline.tick(bench_begin + ms(at));
  EXPECT_EQ(bench.sink.count("m"), before);
  EXPECT_EQ(bench.value("merged m", "Held back without a newer instant", bench_begin + ms(1250)), "1");
  sweep(bench, "b", ms(1255));
  ASSERT_EQ(bench.sink.count("m"), before + 1) << "at once";
  expect_near(bench.sink.scans["m"].back().stamp, bench_begin + ms(1255) - sweep_time);
}

TEST(MergedScanMaker, ARateBeyondThatOfTheSourcesRepeatsNothing) {
  PipelineBench bench(two_sources("rate: 40"));
  for (double at = 100; at <= 2000; at += 5) {
    if (std::fmod(at, 100) == 0) sweep(bench, "a", ms(at));
    if (std::fmod(at, 100) == 50) sweep(bench, "b", ms(at));
    bench.pipeline.tick(bench_begin + ms(at));
  }
  const auto& scans = bench.sink.scans["m"];
  EXPECT_NEAR(static_cast<double>(scans.size()), 38, 2) << "each sweep once";
  for (std::size_t i = 1; i < scans.size(); ++i) EXPECT_GE(scans[i].stamp - scans[i - 1].stamp, ms(49)) << i;
}

TEST(MergedScanMaker, StampsGoBackWithAnInputThatBeginsAgain) {
  PipelineBench bench(two_sources(""));
  for (int loop = 0; loop < 3; ++loop) {
    for (const double at : {500.0, 600.0}) {
      sweep(bench, "a", ms(at));
      sweep(bench, "b", ms(at));
    }
    ASSERT_EQ(bench.sink.count("m"), 2U * static_cast<std::size_t>(loop + 1)) << loop;
    expect_near(bench.sink.scans["m"].back().stamp, bench_begin + ms(600) - sweep_time);
    bench.pipeline.restart();
  }
  EXPECT_EQ(bench.value("merged m", "Sweeps out of order", bench_begin + ms(600)), "0");
}

TEST(MergedScanMaker, OwnBodyIsLeftOutWhereverTheOutputFrameStands) {
  // The body reaches from 1 to 2 m to the left of base_link; a scanner sees something there and, at the same
  // distance, on the other side.
  for (const double yaw : {0.0, 90.0, -135.0}) {
    const std::string frame = "destination_frame: out, destination_pose: {xyz: [0, 0, 0], rpy_deg: [0, 0, " +
                              std::to_string(yaw) + "]}";
    PipelineBench bench(two_sources(frame, "footprint: [[-0.5, 1], [0.5, 1], [0.5, 2], [-0.5, 2]]"));
    for (const char* source : {"a", "b"})
      bench.give(source, round_scan(source, bench_begin, 1.5F), bench_begin);
    ASSERT_EQ(bench.sink.count("m"), 1U);
    const PlanarScan& scan = bench.sink.scans["m"][0];
    EXPECT_EQ(scan.frame_id, "out");
    for (std::size_t i = 0; i < scan.beams; ++i) {
      const double in_base = static_cast<double>(scan.angle(i)) + yaw * M_PI / 180;
      const double left = std::sin(in_base), ahead = std::cos(in_base);
      if (left > 0.98) {
        EXPECT_NE(scan.statuses[i], BeamStatus::hit) << yaw << ": the body at beam " << i;
      }
      if (left < -0.9 || std::abs(ahead) > 0.6) {
        EXPECT_EQ(scan.statuses[i], BeamStatus::hit) << yaw << ", " << i;
      }
    }
  }
}

TEST(MergedScanMaker, FurtherScansHaveTheUsualEncodingsAndTheSameStamp) {
  PipelineBench bench(
      two_sources("profile: strict, empty: zero, unobserved: minus_inf, cloud_destination_topic: cloud, "
                  "also: {safe: safety, flat: flatten}"));
  sweep(bench, "a", ms(100));
  sweep(bench, "b", ms(100));
  const PlanarScan& own = bench.sink.scans["m"].at(0);
  const PlanarScan& safe = bench.sink.scans["safe"].at(0);
  const PlanarScan& flat = bench.sink.scans["flat"].at(0);
  EXPECT_EQ(own.none_as, 0);
  EXPECT_EQ(own.invalid_as, -std::numeric_limits<float>::infinity());
  for (const PlanarScan* further : {&safe, &flat}) {
    EXPECT_EQ(further->none_as, std::numeric_limits<float>::infinity());
    EXPECT_TRUE(std::isnan(further->invalid_as));
  }
  EXPECT_EQ(safe.stamp, own.stamp);
  EXPECT_EQ(flat.stamp, own.stamp);
  EXPECT_EQ(bench.sink.clouds["cloud"].at(0).stamp, own.stamp);
  EXPECT_EQ(bench.sink.clouds["cloud"].at(0).frame_id, "base_link");
  EXPECT_EQ(bench.sink.clouds["cloud"].at(0).size(), 2U * 361U);
  EXPECT_EQ(bench.sink.topics, (std::vector<std::string>{"m", "safe", "flat", "cloud"}));
}

}  // namespace
}  // namespace lidard
