// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Messages of other drivers: their stamps, scans that are not sound, and the rhythm of diagnostics.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "test/support/pipeline_bench.h"

namespace lidard {
namespace {

using test::bench_begin;
using test::PipelineBench;
using test::round_scan;
using testing::HasSubstr;

TEST(ForeignMessages, TimeOffsetMovesTheBeginAndTheEndOfAFrame) {
  PipelineBench bench(
      "vehicle: {odometry_topic: /odom}\n"
      "sensors: {roof: {topic: /roof, pose: {xyz: [0, 0, 1]}, time_offset: -0.05},\n"
      "          front: {topic: /front, pose: {xyz: [0, 0, 0]}, time_offset: 0.02}}\n"
      "merged_scans: {m: {laserscan_topics: front, range_max: 20, beams: 360}}\n"
      "virtual_scans: {v: {cloud_topic: roof, virtual_laser_scan: [low], poses: {low: {xyz: [0, 0, 0]}}}}\n");
  for (int at = -200; at <= 400; at += 10)
    bench.pipeline.pose_message(bench_begin + ms(at), Pose::Identity(), "", bench_begin + ms(at));
  Cloud cloud;
  cloud.frame_id = "roof";
  cloud.stamp = bench_begin;
  cloud.end = bench_begin + ms(100);
  bench.give("roof", cloud, bench_begin + ms(400));
  ASSERT_EQ(bench.sink.count("low"), 1U);
  EXPECT_EQ(bench.sink.scans["low"][0].stamp, bench_begin + ms(100 - 50)) << "a moved cloud is of its end";
  bench.give("front", round_scan("front", bench_begin + ms(100), 5, 361, ms(80)), bench_begin + ms(400));
  ASSERT_EQ(bench.sink.count("m"), 1U);
  EXPECT_NEAR(seconds(bench.sink.scans["m"][0].stamp - (bench_begin + ms(100 + 80 + 20))), 0, 1e-6);
}

TEST(ForeignMessages, AScanThatIsNotSoundIsRejectedAndCounted) {
  PipelineBench bench(
      "sensors: {a: {topic: /a, pose: {xyz: [0, 0, 0]}}}\n"
      "merged_scans: {m: {laserscan_topics: a, range_max: 20, beams: 360}}\n");
  PlanarScan scan = round_scan("a", bench_begin);
  scan.ranges[5] = 31;  // beyond its own range_max
  bench.give("a", scan, bench_begin);
  EXPECT_EQ(bench.sink.count("m"), 0U);
  const SensorStatus report = bench.pipeline.status(bench.pipeline.now()).sensors[0];
  EXPECT_EQ(report.counters.packets, 1U);
  EXPECT_EQ(report.counters.frames, 0U);
  EXPECT_EQ(report.counters.rejected[static_cast<std::size_t>(Reject::field)], 1U);
  EXPECT_EQ(bench.item("sensor a", bench_begin).health, Health::error);
}

TEST(ForeignMessages, DiagnosticsComeOncePerSecondAndWhenTheClockIsSetBack) {
  PipelineBench bench("sensors: {a: {topic: /a}}");
  const auto told = [&](double at) {
    bench.pipeline.tick(bench_begin + ms(at));
    return bench.sink.tellings;
  };
  EXPECT_EQ(told(0), 1);
  EXPECT_EQ(told(999), 1);
  EXPECT_EQ(told(1000), 2);
  EXPECT_EQ(told(1999), 2);
  EXPECT_EQ(told(2000), 3);
  EXPECT_EQ(told(2500), 3);
  EXPECT_EQ(told(900), 4);
  EXPECT_EQ(told(1899), 4);
  EXPECT_EQ(told(1900), 5);
}

TEST(ForeignMessages, ATickThatComesALittleLateToATimeAlreadyKnownDoesNotGoBack) {
  PipelineBench bench("sensors: {a: {topic: /a}}");
  bench.pipeline.tick(bench_begin);
  bench.give("a", round_scan("a", bench_begin + ms(1500)), bench_begin + ms(1500));
  bench.pipeline.tick(bench_begin + ms(1400));
  EXPECT_EQ(bench.sink.tellings, 2);
  bench.pipeline.tick(bench_begin + ms(2250));
  EXPECT_EQ(bench.sink.tellings, 2) << "less than a second after 1500";
  bench.pipeline.tick(bench_begin + ms(2500));
  EXPECT_EQ(bench.sink.tellings, 3);
}

TEST(ForeignMessages, WhatOthersKnowIsAddedToEveryListOfDiagnostics) {
  PipelineBench bench("sensors: {a: {topic: /a}}");
  bench.add_items = [](std::vector<DiagnosticItem>& items) {
    items.push_back({"socket", "", Health::warn, "full", {}});
  };
  bench.pipeline.tick(bench_begin);
  EXPECT_EQ(bench.sink.item("socket").message, "full");
  EXPECT_EQ(bench.sink.item("socket").health, Health::warn);
}

TEST(ForeignMessages, AfterALongPauseOutputsOfThePastAreNotMadeUpFor) {
  PipelineBench bench(
      "sensors: {a: {topic: /a, pose: {xyz: [0, 0, 0]}}}\n"
      "merged_scans: {m: {laserscan_topics: a, range_max: 20, beams: 360, rate: 10, deadline: 100, "
      "lost_after: 100}}\n");
  const auto come_at = [&](double at) {
    bench.give("a", round_scan("a", bench_begin + ms(at)), bench_begin + ms(at));
    bench.pipeline.tick(bench_begin + ms(at));
  };
  for (double at = 0; at <= 1000; at += 100) come_at(at);
  EXPECT_GE(bench.sink.count("m"), 10U);
  come_at(31'000);
  EXPECT_LE(bench.sink.count("m"), 11U + 12U);
  for (const Stamp released : bench.sink.released["m"])
    EXPECT_TRUE(released <= bench_begin + ms(1000) || released >= bench_begin + ms(30'000));
}

}  // namespace
}  // namespace lidard
