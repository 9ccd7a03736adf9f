// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// A merged scan beside its beams: its stamp, its figures in /diagnostics, and what a change of its settings
// leaves as it was.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

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
