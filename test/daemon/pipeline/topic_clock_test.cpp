// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Sources whose messages are stamped by a clock that is not this host's.
#include "core/base/topic_clock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "test/daemon/pipeline/merged_output_bench.h"
#include "test/sim/servers/velodyne_stream.h"

namespace lidard {
namespace {

using namespace test::merged;
using test::bench_begin;
using test::PipelineBench;
using test::round_scan;
using testing::AllOf;
using testing::HasSubstr;

const Span hour = std::chrono::hours(1);

/// Sweeps of both sources from `from` to `until`; those of b are stamped `ahead` of the host's clock, and
/// arrive after up to 4 ms.
void drive(PipelineBench& bench, Span from, Span until, Span ahead) {
  int n = 0;
  for (Span at = from; at < until; at += ms(100)) {
    sweep(bench, "a", at);
    const Span end = at + ms(10);
    bench.give("b", round_scan("b", bench_begin + end - sweep_time + ahead, 5, 361, sweep_time),
               bench_begin + end + ms(n++ % 5));
    bench.pipeline.tick(bench_begin + at + ms(20));
  }
}

/// Each merged scan is stamped after the one before, at most when it came out, and shows the last 0.2 s.
void expect_of_this_clock(PipelineBench& bench, const std::string& topic, std::size_t from = 0) {
  const auto& scans = bench.sink.scans[topic];
  const auto& released = bench.sink.released[topic];
  for (std::size_t i = from; i < scans.size(); ++i) {
    EXPECT_LE(scans[i].stamp, released[i]) << i;
    EXPECT_LT(released[i] - scans[i].stamp, ms(200)) << i;
    if (i > from) {
      EXPECT_GT(scans[i].stamp, scans[i - 1].stamp) << i;
    }
  }
}

TEST(TopicClock, ASourceAnHourAheadOrBehindIsPlacedByItsArrivalsAndNamedWithTheRemedy) {
  for (const Span ahead : {hour, -hour, Span(ms(100)), Span(-ms(11'000))}) {
    PipelineBench bench(two_sources(""));
    drive(bench, ms(100), ms(3000), ahead);
    expect_of_this_clock(bench, "m");
    ASSERT_GT(bench.sink.count("m"), 25U) << seconds(ahead);
    const Stamp now = bench_begin + ms(3010);
    const DiagnosticItem b = bench.item("sensor b", now);
    EXPECT_EQ(b.health, Health::warn) << seconds(ahead);
    EXPECT_THAT(b.message,
                AllOf(HasSubstr("topic /b"), HasSubstr(ahead > Span(0) ? "ahead of" : "behind"),
                      HasSubstr("chrony"), HasSubstr("time_offset: "), HasSubstr("/use_sim_time")));
    EXPECT_EQ(test::value_of(b, "Stamps replaced"), "29");
    EXPECT_EQ(bench.item("sensor a", now).message, "receiving");
    EXPECT_EQ(bench.item("merged m", now).health, Health::ok) << "what it shows is of now";
  }
}

TEST(TopicClock, TheRemedyWithTheOffsetThatIsNamedEndsTheWarning) {
  PipelineBench bench(
      "sensors: {b: {topic: /b, pose: {xyz: [0, 0, 0]}, time_offset: -3600}}\n"
      "merged_scans: {m: {laserscan_topics: [b], beams: 90, range_max: 9}}\n");
  for (double at = 100; at < 2000; at += 100)
    bench.give("b", round_scan("b", bench_begin + ms(at - 80) + hour), bench_begin + ms(at));
  EXPECT_EQ(bench.item("sensor b", bench_begin + ms(2000)).message, "receiving");
  EXPECT_EQ(bench.sink.scans["m"].back().stamp, bench_begin + ms(1820));
}

TEST(TopicClock, KeepsTheIntervalsOfTheOtherClock) {
  TopicClock clock;
  Stamp last{};
  for (int i = 0; i < 200; ++i) {
    const Stamp measured = bench_begin + ms(50 * i);
    const Stamp is = clock.correct(measured + hour, ms(40), measured + ms(42 + i * 7 % 9));
    EXPECT_LE(is, measured + ms(42 + i * 7 % 9) - ms(40));
    if (i > 9) {
      EXPECT_NEAR(seconds(is - last), 0.05, 0.0005) << i;
    }
    last = is;
  }
  EXPECT_NEAR(seconds(last - (bench_begin + ms(50 * 199))), 0.002, 0.001);
}

TEST(TopicClock, StampsThatAreMissingOrStandStillBecomeTheArrival) {
  for (const Stamp stamp : {Stamp{}, bench_begin - hour, bench_begin + hour}) {
    TopicClock clock;
    for (int i = 1; i < 50; ++i)
      EXPECT_EQ(clock.correct(stamp, ms(10), bench_begin + ms(100 * i)), bench_begin + ms(100 * i - 10));
    EXPECT_EQ(clock.replaced(), 49U);
    EXPECT_NE(clock.ahead(), std::nullopt);
  }
}

TEST(TopicClock, AClockThatIsSetWhileItRunsIsFollowedAndTheWarningEndsWithTheFault) {
  PipelineBench bench(two_sources(""));
  drive(bench, ms(100), ms(3000), Span(0));
  EXPECT_EQ(bench.item("sensor b", bench_begin + ms(3000)).health, Health::ok);
  Span at = ms(3000);
  for (const Span ahead : {hour, 2 * hour, -hour, hour}) {
    drive(bench, at, at + ms(2000), ahead);
    EXPECT_EQ(bench.item("sensor b", bench_begin + at + ms(2000)).health, Health::warn);
    at += ms(2000);
  }
  drive(bench, at, at + ms(3000), Span(0));
  EXPECT_EQ(bench.item("sensor b", bench_begin + at + ms(3000)).health, Health::ok);
  expect_of_this_clock(bench, "m");
  EXPECT_GT(bench.sink.count("m"), 130U) << "hardly any is missing";
}

TEST(TopicClock, AFewStampsOfAnotherClockAreCountedAndNoWarning) {
  TopicClock clock;
  for (int i = 0; i < 100; ++i)
    clock.correct(bench_begin + ms(i) + (i % 50 == 10 ? hour : Span(0)), Span(0), bench_begin + ms(i));
  EXPECT_EQ(clock.replaced(), 2U);
  EXPECT_EQ(clock.ahead(), std::nullopt);
}

TEST(TopicClock, AClockThatIsAheadByMillisecondsMakesNoStampBeyondTheArrival) {
  TopicClock clock;
  for (int i = 0; i < 100; ++i) {
    const Stamp arrival = bench_begin + ms(100 * i);
    EXPECT_EQ(clock.correct(arrival - ms(40) + ms(i % 20), ms(40), arrival), arrival - ms(40));
    EXPECT_EQ(clock.correct(arrival - ms(40 + i % 20), ms(40), arrival), arrival - ms(40 + i % 20));
  }
  EXPECT_EQ(clock.ahead(), std::nullopt);
}

TEST(TopicClock, StampsOfASimulatorAreKeptAndJudgedByItsClock) {
  const Span simulated = -std::chrono::hours(400'000);
  for (const Span b_ahead : {Span(0), hour}) {
    PipelineBench bench(two_sources(""));
    bench.pipeline.set_message_clock(simulated);
    for (double at = 100; at <= 3000; at += 100) {
      for (const char* source : {"a", "b"})
        bench.give(
            source,
            round_scan(source, bench_begin + simulated + ms(at - 80) + (*source == 'b' ? b_ahead : Span(0))),
            bench_begin + ms(at));
    }
    const Stamp now = bench_begin + ms(3010);
    EXPECT_EQ(bench.item("sensor a", now).message, "receiving");
    EXPECT_EQ(bench.item("sensor b", now).health, b_ahead == Span(0) ? Health::ok : Health::warn);
    ASSERT_GT(bench.sink.count("m"), 25U);
    const Span late = bench.sink.released["m"].back() + simulated - bench.sink.scans["m"].back().stamp;
    EXPECT_GE(late, Span(0));
    EXPECT_LE(late, ms(100));
  }
}

TEST(TopicClock, CloudsOfAnotherClockAreMergedAsOfTheirArrival) {
  PipelineBench bench(
      "sensors: {a: {topic: /a, pose: {xyz: [0, 0, 2]}}, b: {topic: /b, pose: {xyz: [0, 0, 2]}}}\n"
      "merged_clouds: {around: {sources: [a, b]}}\n");
  for (double end = 100; end <= 3000; end += 100) {
    for (const char* source : {"a", "b"}) {
      Cloud cloud;
      cloud.frame_id = source;
      cloud.end = bench_begin + ms(end) + (*source == 'b' ? hour : Span(0));
      cloud.stamp = cloud.end - ms(90);
      cloud.points_bytes.resize(sizeof(CloudPoint));
      cloud.points()[0] = {5, 0, 0, 7, 0, 0.09F};
      bench.give(source, cloud, bench_begin + ms(end));
    }
  }
  const auto& merged = bench.sink.merged_clouds["around"];
  ASSERT_GT(merged.size(), 25U);
  for (std::size_t i = 0; i < merged.size(); ++i) {
    EXPECT_LE(merged[i].stamp, bench.sink.released["around"][i] - ms(90));
    EXPECT_EQ(merged[i].size(), 2U);
  }
  EXPECT_EQ(bench.item("sensor b", bench_begin + ms(3010)).health, Health::warn);
}

TEST(TopicClock, PacketsThatAnotherComputerStampedAreCloudsOfTheirArrival) {
  sim::VelodyneSetup setup;
  setup.duration = std::chrono::milliseconds(450);
  const auto packets = simulate_velodyne(setup);
  for (const Span ahead : {hour, -hour}) {
    PipelineBench bench("sensors: {roof: {model: velodyne_vlp16, packet_topic: /packets}}\n");
    Stamp last{};
    for (const auto& packet : packets) {
      bench.pipeline.packet_message("roof", {packet.view(), packet.arrival + ahead, {}, {}},
                                    packet.arrival + ms(1));
      last = packet.arrival + ms(1);
    }
    const auto& clouds = bench.sink.clouds["roof/points"];
    ASSERT_GE(clouds.size(), 3U);
    for (std::size_t i = 1; i < clouds.size(); ++i) {
      EXPECT_LE(clouds[i].end, bench.sink.released["roof/points"][i]) << i;
      EXPECT_NEAR(seconds(clouds[i].stamp - clouds[i - 1].stamp), 0.1, 0.002) << i;
    }
    const DiagnosticItem roof = bench.item("sensor roof", last);
    EXPECT_EQ(roof.health, Health::warn);
    EXPECT_THAT(roof.message, HasSubstr(ahead > Span(0) ? "3600.00 s ahead of" : "3600.00 s behind"));
  }
}

TEST(TopicClock, PacketsWhoseStampsStandStillAreCloudsOfTheirArrival) {
  sim::VelodyneSetup setup;
  setup.duration = std::chrono::milliseconds(650);
  const auto packets = simulate_velodyne(setup);
  for (const Stamp stamp : {Stamp{}, packets.front().arrival - hour, packets.front().arrival + hour}) {
    PipelineBench bench("sensors: {roof: {model: velodyne_vlp16, packet_topic: /packets}}\n");
    for (const auto& packet : packets)
      bench.pipeline.packet_message("roof", {packet.view(), stamp, {}, {}}, packet.arrival + ms(1));
    const auto& clouds = bench.sink.clouds["roof/points"];
    ASSERT_GE(clouds.size(), 5U);
    for (std::size_t i = 1; i < clouds.size(); ++i) {
      const Stamp released = bench.sink.released["roof/points"][i];
      EXPECT_LE(clouds[i].end, released) << i;
      EXPECT_GT(clouds[i].end, released - ms(10)) << i;
      EXPECT_NEAR(seconds(clouds[i].stamp - clouds[i - 1].stamp), 0.1, 0.002) << i;
    }
    EXPECT_EQ(bench.item("sensor roof", packets.back().arrival + ms(1)).health, Health::warn);
  }
}

TEST(TopicClock, OdometryOfAnotherClockMovesTheScansAndIsNamed) {
  for (const Span ahead : {hour, -hour}) {
    PipelineBench bench(two_sources("on_missing_motion: drop", "odometry_topic: /odom"));
    for (double at = 100; at <= 3000; at += 10) {
      const Stamp now = bench_begin + ms(at);
      bench.pipeline.pose_message(now + ahead, make_pose({0, 0, 0}, {0, 0, at / 3000}), "", now);
      if (std::fmod(at, 100) == 0) sweep(bench, "a", ms(at));
      if (std::fmod(at, 100) == 10) sweep(bench, "b", ms(at));
    }
    const Stamp now = bench_begin + ms(3005);
    EXPECT_GT(bench.sink.count("m"), 20U) << "its poses are used";
    expect_of_this_clock(bench, "m");
    const DiagnosticItem motion = bench.item("motion", now);
    EXPECT_EQ(motion.health, Health::warn);
    EXPECT_THAT(motion.message, AllOf(HasSubstr("topic /odom"), HasSubstr("3600.00 s")));
    EXPECT_EQ(test::value_of(motion, "Stamps replaced"), "291");
  }
}

TEST(TopicClock, SourcesOfASimulatorAndOfThisHostInOneScanAreAWarning) {
  PipelineBench bench(two_sources(""));
  const Span simulated = -std::chrono::hours(1);
  for (double at = 100; at <= 3000; at += 100) {
    bench.pipeline.set_message_clock(Span(0));
    sweep(bench, "a", ms(at));
    bench.pipeline.set_message_clock(simulated);
    bench.give("b", round_scan("b", bench_begin + simulated + ms(at - 80)), bench_begin + ms(at));
    bench.pipeline.tick(bench_begin + ms(at + 1));
  }
  const DiagnosticItem merged = bench.item("merged m", bench_begin + ms(3010));
  EXPECT_EQ(merged.health, Health::warn);
  EXPECT_THAT(merged.message, HasSubstr("3600 s apart"));
}

}  // namespace
}  // namespace lidard
