// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// What /diagnostics says of a merged scan and its sources.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

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

TEST(MergedScanMaker, NamesAStaleSourceAsAWarningAndALostOneAsAnError) {
  PipelineBench bench(two_sources(""));
  for (double at = 100; at <= 3000; at += 100) {
    sweep(bench, "a", ms(at));
    if (at <= 2000) sweep(bench, "b", ms(at));
  }
  // b was due at 2100 and is waited for 0.3 periods more; it is lost 0.4 s after its last sweep.
  const auto item_at = [&](double at) { return bench.item("merged m", bench_begin + ms(at)); };
  EXPECT_EQ(item_at(3001).health, Health::error);
  EXPECT_EQ(item_at(3001).message, "publishing without b; see the state of its sensors");
  EXPECT_EQ(test::value_of(item_at(3001), "Sources lost"), "b");
  EXPECT_THAT(test::value_of(item_at(3001), "Source b"), MatchesRegex("lost, 10.0 Hz, age 1001 ms"));

  PipelineBench late(two_sources("deadline: 0.05, lost_after: 5"));
  const auto until = [&](double begin, double end) {
    for (double at = begin; at <= end; at += 100) {
      sweep(late, "a", ms(at));
      if (at <= 2000) sweep(late, "b", ms(at));
      late.pipeline.tick(bench_begin + ms(at));
    }
    return late.item("merged m", bench_begin + ms(end + 10));
  };
  EXPECT_EQ(until(100, 2900).health, Health::ok) << "it is stale from 2150 on, for less than ten outputs";
  const DiagnosticItem stale = until(3000, 3300);
  EXPECT_EQ(stale.health, Health::warn);
  EXPECT_EQ(stale.message, "publishing without b, whose sweeps are too old; see the state of its sensors");
  EXPECT_EQ(test::value_of(stale, "Sources lost"), "");
}

TEST(MergedScanMaker, SaysWhichDeadlineWaitsForASourceWhoseSweepsComeLateEachTime) {
  PipelineBench bench(two_sources(""));
  for (double at = 100; at <= 3000; at += 100) {
    sweep(bench, "a", ms(at));
    // They come 0.18 s after their end, as with a time_offset of -0.18.
    bench.give("b", round_scan("b", bench_begin + ms(at - 180) - sweep_time, 5, 361, sweep_time),
               bench_begin + ms(at));
    bench.pipeline.tick(bench_begin + ms(at));
  }
  EXPECT_EQ(bench.item("merged m", bench_begin + ms(3010)).message,
            "publishing without b, whose sweeps are too old; a deadline of 0.10 waits for them");
}

TEST(MergedScanMaker, RaisesNoAlarmOfASourceThatIsStaleForMilliseconds) {
  // A busy machine: the sweeps of b come in 60 ms late now and then.
  PipelineBench bench(two_sources("lost_after: 5"));
  std::vector<std::pair<double, Health>> states;
  bench.add_items = [&](std::vector<DiagnosticItem>& items) {
    for (const DiagnosticItem& item : items) {
      if (item.name != "merged m" || (!states.empty() && states.back().second == item.health)) continue;
      states.emplace_back(
          seconds(bench.sink.released["m"].empty() ? Span(0) : bench.sink.released["m"].back() - bench_begin),
          item.health);
    }
  };
  const auto pass = [&](double begin, double end, double late_ms) {
    for (double at = begin; at < end; at += 10) {
      const bool due = std::fmod(at, 100) == 0;
      if (due) sweep(bench, "a", ms(at));
      if (std::fmod(at - late_ms, 100) == 0 && at >= begin + late_ms) {
        bench.give("b", round_scan("b", bench_begin + ms(at - late_ms) - sweep_time, 5, 361, sweep_time),
                   bench_begin + ms(at));
      }
      bench.pipeline.tick(bench_begin + ms(at));
    }
  };
  pass(100, 2000, 0);
  const std::size_t well = states.size();
  for (double second = 2000; second < 12000; second += 1000) {
    pass(second, second + 600, 0);
    pass(second + 600, second + 1000, 60);
  }
  EXPECT_EQ(states.size(), well) << "stale for milliseconds, ten times";
  EXPECT_GE(bench.value("merged m", "Sources waited for in vain", bench_begin + ms(12000)), "1");
}

TEST(MergedScanMaker, CountsWhatItWaitedForInVain) {
  PipelineBench bench(two_sources("lost_after: 5"));
  for (double at = 100; at <= 2000; at += 100) {
    sweep(bench, "a", ms(at));
    if (at <= 1000) sweep(bench, "b", ms(at));
    bench.pipeline.tick(bench_begin + ms(at + 50));
  }
  EXPECT_EQ(bench.value("merged m", "Sources waited for in vain", bench_begin + ms(1000)), "10");
  EXPECT_GE(bench.sink.count("m"), 18U);
}

TEST(MergedScanMaker, CountsSweepsThatAreReplacedOutOfOrderOrOfImpossibleTimes) {
  PipelineBench bench(two_sources(""));
  sweep(bench, "a", ms(100));
  sweep(bench, "a", ms(110));
  sweep(bench, "a", ms(105));
  PlanarScan odd = round_scan("a", bench_begin + ms(120));
  odd.time_increment = 1;
  bench.give("a", odd, bench_begin + ms(120));
  sweep(bench, "b", ms(130));
  const Stamp now = bench_begin + ms(130);
  EXPECT_EQ(bench.value("merged m", "Sweeps replaced before use", now), "1");
  EXPECT_EQ(bench.value("merged m", "Sweeps out of order", now), "1");
  EXPECT_EQ(bench.value("merged m", "Sweeps with impossible times", now), "1");
}

TEST(MergedScanMaker, SaysWhyNothingCameForEachOfItsTopics) {
  PipelineBench bench(
      two_sources("cloud_destination_topic: cloud, status_topic: known, also: {safe: safety}"));
  for (const char* topic : {"m", "cloud", "known", "safe"})
    EXPECT_THAT(why_missing(bench.pipeline, topic),
                ::testing::MatchesRegex("no output: no input has come in yet; see the state of its sensors; "
                                        "a: nothing received.*; b: nothing received.*"))
        << topic;
  EXPECT_EQ(why_missing(bench.pipeline, "other"), "");
  sweep(bench, "b", ms(100));
  sweep(bench, "a", ms(100));
  bench.pipeline.tick(bench_begin + ms(110));
  EXPECT_EQ(why_missing(bench.pipeline, "m"), "");
}

TEST(MergedScanMaker, ThatGivesNothingSaysSoAfterThreeSeconds) {
  PipelineBench bench(two_sources(""));
  for (double at = 100; at <= 2000; at += 100) {
    sweep(bench, "a", ms(at));
    sweep(bench, "b", ms(at));
  }
  const Stamp last = bench.sink.released["m"].back();
  for (double at = 2100; at <= 6000; at += 100) bench.pipeline.tick(bench_begin + ms(at));
  ASSERT_EQ(bench.sink.released["m"].back(), last) << "nobody delivers";
  EXPECT_EQ(bench.item("merged m", last + ms(2999)).message,
            "no output, since no source delivers; see the state of its sensors");
  const DiagnosticItem item = bench.item("merged m", last + ms(3001));
  EXPECT_EQ(item.health, Health::error);
  EXPECT_EQ(item.message, "no output for more than 3 s; see the state of its sensors");
}

TEST(MergedScanMaker, ASlowRateIsNoErrorBetweenItsOutputs) {
  PipelineBench bench(two_sources("policy: rate, rate: 0.1"));
  for (double at = 100; at <= 9000; at += 100) {
    sweep(bench, "a", ms(at));
    sweep(bench, "b", ms(at));
    bench.pipeline.tick(bench_begin + ms(at));
  }
  const Stamp last = bench.sink.released["m"].back();
  EXPECT_EQ(bench.item("merged m", last + ms(8000)).message, "publishing");
  EXPECT_EQ(bench.item("merged m", last + ms(15'100)).message,
            "no output for more than 15 s; see the state of its sensors");
}

TEST(MergedScanMaker, ASweepWithoutAPlaceIsCountedAndItsSourceNamed) {
  PipelineBench bench(
      "sensors: {a: {topic: /a}, b: {topic: /b, pose: {xyz: [0, 0, 0]}}}\n"
      "merged_scans: {m: {laserscan_topics: [a, b], beams: 360, range_max: 20}}\n");
  for (int i = 0; i < 3; ++i)
    bench.give("a", round_scan("lost_frame", bench_begin + ms(100 * i)), bench_begin + ms(100 * i));
  EXPECT_EQ(bench.value("merged m", "Inputs without pose", bench_begin + ms(300)), "3");
  EXPECT_THAT(bench.item("merged m", bench_begin + ms(300)).message, HasSubstr("no tf from lost_frame"));
  bench.tf.set("base_link", "lost_frame", Pose::Identity());
  bench.give("a", round_scan("lost_frame", bench_begin + ms(300)), bench_begin + ms(300));
  EXPECT_EQ(bench.value("merged m", "Inputs without pose", bench_begin + ms(300)), "3");
}

TEST(MergedScanMaker, AReasonThatIsOverIsNotNamedAndAnotherOneIs) {
  PipelineBench bench(
      "sensors: {a: {topic: /a}, b: {topic: /b, pose: {xyz: [0, 0, 0]}}}\n"
      "merged_scans: {m: {laserscan_topics: [a, b], beams: 360, range_max: 20}}\n");
  Stamp now = bench_begin;
  const auto after = [&](Span time, const std::string& frame_of_a) {
    for (const Stamp end = now + time; now < end; now = now + ms(100)) {
      if (!frame_of_a.empty()) bench.give("a", round_scan(frame_of_a, now), now);
      bench.give("b", round_scan("b", now), now);
      bench.pipeline.tick(now);
    }
    return bench.item("merged m", now).message;
  };
  const Span some = std::chrono::seconds(8);
  EXPECT_EQ(after(some, "a"), "publishing without a: no tf from a to base_link");
  bench.tf.set("base_link", "a", Pose::Identity());
  EXPECT_EQ(after(some, "a"), "publishing");
  EXPECT_EQ(after(some, ""), "publishing without a; see the state of its sensors") << "its pose was found";
  EXPECT_EQ(after(some, "a2"), "publishing without a: no tf from a2 to base_link");
}

}  // namespace
}  // namespace lidard
