// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// The queue of the publishing thread, which stands still here.
#include "daemon/ros/out/publisher_thread.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <set>
#include <thread>

#include "test/support/ros_samples.h"

namespace lidard {
namespace {

using namespace std::chrono_literals;
using test::sample_cloud;
using test::sample_scan;

struct Bench {
  explicit Bench(Backpressure backpressure = Backpressure::drop_oldest) {
    options.backpressure = backpressure;
    publisher.emplace(options, watch, [](std::size_t, const auto&) {});
    sink = &publisher->add_sink();
    sink->set_topics(test::sample_topics());
  }
  void push_scan(Span released) { sink->publish(test::front_scan, sample_scan(), Stamp{} + released); }
  std::uint64_t dropped(const OutputTopic& topic) { return publisher->figures(topic.name, Stamp{}).dropped; }

  RosOptions options;
  ThreadWatch watch;
  std::optional<PublisherThread> publisher;
  PublisherThread::Sink* sink = nullptr;
};

TEST(PublisherThread, DropsTheOldestAndCountsItWhenTheSensorThreadIsFaster) {
  Bench bench;
  for (int i = 1; i <= 5; ++i) {
    Cloud cloud = sample_cloud(1);
    bench.sink->publish(test::roof_points, cloud, Stamp{i});
  }
  EXPECT_EQ(bench.dropped(test::roof_points), 3U);
  EXPECT_EQ(bench.publisher->dropped(), 3U);
  EXPECT_EQ(bench.publisher->in_flight(), 2U);
}

TEST(PublisherThread, LosesNoScanOfAScannerWhileItStandsForHalfASecond) {
  Bench bench;
  for (Span at = 0s; at < 500ms; at += 20ms) bench.push_scan(at);
  for (Span at = 0s; at < 500ms; at += 20ms) bench.push_scan(500ms);  // TCP delivers them in one piece
  EXPECT_EQ(bench.publisher->dropped(), 0U);
}

TEST(PublisherThread, KeepsNoScanThatIsASecondOldAndAtMostAHundred) {
  Bench bench;
  for (Span at = 0s; at <= 3s; at += 50ms) bench.push_scan(at);
  EXPECT_EQ(bench.publisher->dropped(), 40U);
  for (int i = 0; i < 250; ++i) bench.push_scan(3s);
  EXPECT_EQ(bench.publisher->dropped(), 211U) << "a hundred of 311 wait";
  bench.push_scan(10s);
  EXPECT_EQ(bench.publisher->in_flight(), 2U) << "two wait, however old they are";
}

TEST(PublisherThread, LetsAnImuRunAheadFurtherThanAFix) {
  Bench bench;
  for (int i = 0; i < 58; ++i)
    bench.sink->publish(test::roof_imu, DeviceMessage(test::sample_imu()), Stamp{i});
  for (int i = 0; i < 5; ++i)
    bench.sink->publish(test::roof_fix, DeviceMessage(test::sample_fix()), Stamp{i});
  EXPECT_EQ(bench.dropped(test::roof_imu), 8U);
  EXPECT_EQ(bench.dropped(test::roof_fix), 3U);
}

TEST(PublisherThread, LeavesTheCallerABufferForTheNextCloudAndNeedsNoNewOneAfterAWhile) {
  Bench bench;
  auto cloud = sample_cloud(100);
  std::set<const void*> buffers;
  for (int i = 0; i < 20; ++i) {
    const auto size = cloud.points_bytes.size();
    buffers.insert(cloud.points_bytes.data());
    bench.sink->publish(test::roof_points, cloud, Stamp{i});
    cloud.points_bytes.resize(size);
  }
  EXPECT_LE(buffers.size(), 4U) << "the caller's and those of two frames that wait and one that is published";
}

TEST(PublisherThread, MakesAReplayWaitUntilThereIsRoomAndLetsItGoWhenStopped) {
  Bench bench(Backpressure::block);
  std::atomic<int> pushed{0};
  std::thread sensor([&] {
    for (int i = 1; i <= 5; ++i, ++pushed) bench.push_scan(Span(i));
  });
  for (int i = 0; i < 4000 && pushed < 2; ++i) std::this_thread::sleep_for(5ms);
  std::this_thread::sleep_for(50ms);
  EXPECT_EQ(pushed, 2) << "no room for a third";
  bench.publisher->stop();
  sensor.join();
  EXPECT_EQ(pushed, 5);
  EXPECT_EQ(bench.publisher->dropped(), 0U);
}

TEST(PublisherThread, MeasuresTheRatesOfAReplayInTheTimeOfTheCapture) {
  Bench bench(Backpressure::block);
  for (std::int64_t i = 0; i < 5; ++i) bench.sink->skip(test::roof_points, Stamp{i * 100'000'000});
  EXPECT_EQ(bench.publisher->figures("roof/points", Stamp{std::chrono::hours(100'000) / 1ns}).rate_hz, 10);
}

TEST(PublisherThread, CountsAFrameThatNobodyWantsAndHoldsNothingOfIt) {
  Bench bench;
  for (std::int64_t i = 0; i < 5; ++i) bench.sink->skip(test::roof_points, Stamp{i * 100'000'000});
  const TopicFigures figures = bench.publisher->figures("roof/points", Stamp{500'000'000});
  EXPECT_EQ(figures.frames, 5U);
  EXPECT_EQ(figures.rate_hz, 10);
  EXPECT_EQ(figures.dropped, 0U);
  EXPECT_EQ(bench.publisher->in_flight(), 0U);
}

}  // namespace
}  // namespace lidard
