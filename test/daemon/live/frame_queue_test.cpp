// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/frame_queue.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <set>
#include <thread>
#include <vector>

#include "test/support/ros_samples.h"

namespace lidard {
namespace {

using namespace std::chrono_literals;
using test::sample_cloud;
using test::sample_scan;

/// A slot for each of test::sample_topics(), with room for a hundred scans, two clouds or fixes and fifty
/// samples, and one for the clock.
void add_slots(FrameQueue& queue) {
  for (const std::size_t depth : {100U, 100U, 2U, 2U, 2U, 50U, 2U}) queue.add_slot(depth);
}
constexpr std::size_t clock_slot = 6;

TEST(FrameQueue, DropsTheOldestAndCountsItWhenTheSensorThreadIsFaster) {
  FrameQueue queue(Backpressure::drop_oldest);
  add_slots(queue);
  for (int i = 1; i <= 5; ++i) {
    Cloud cloud = sample_cloud(1);
    cloud.stamp.ns = i;
    queue.push(test::roof_points.id, cloud, Stamp{i});
  }
  EXPECT_EQ(queue.dropped(), 3U);
  auto* first = queue.pop(1ms);
  ASSERT_NE(first, nullptr);
  EXPECT_EQ(std::get<Cloud>(first->content).stamp.ns, 4);
  queue.done(first);
  EXPECT_FALSE(queue.idle());
  auto* second = queue.pop(1ms);
  ASSERT_NE(second, nullptr);
  EXPECT_EQ(std::get<Cloud>(second->content).stamp.ns, 5);
  queue.done(second);
  EXPECT_TRUE(queue.idle());
  EXPECT_EQ(queue.pop(1ms), nullptr);
}

/// Stamps in ms of the frames that wait.
std::vector<std::int64_t> waiting(FrameQueue& queue) {
  std::vector<std::int64_t> stamps;
  while (QueuedFrame* const frame = queue.pop(0ms)) {
    stamps.push_back(std::get<PlanarScan>(frame->content).stamp.ns / 1'000'000);
    queue.done(frame);
  }
  return stamps;
}

TEST(FrameQueue, LosesNoScanOfAScannerWhileTheThreadThatPublishesStandsForHalfASecond) {
  FrameQueue queue(Backpressure::drop_oldest);
  add_slots(queue);
  auto scan = sample_scan();
  const auto push = [&](Span at, Span released) {
    scan.stamp = Stamp{} + at;
    queue.push(test::front_scan.id, scan, Stamp{} + released);
  };
  std::vector<std::int64_t> all;
  for (Span at = 0s; at < 500ms; at += 20ms) push(at, at), all.push_back(at / 1ms);
  EXPECT_EQ(waiting(queue), all);
  for (Span at = 0s; at < 500ms; at += 20ms) push(at, 500ms);
  EXPECT_EQ(waiting(queue), all) << "also those that TCP delivers in one piece";
  EXPECT_EQ(queue.dropped(), 0U);
  EXPECT_EQ(queue.figures(test::front_scan.id, Stamp{} + 1s).dropped, 0U);
}

TEST(FrameQueue, KeepsNoScanThatIsASecondOldAndAtMostAHundred) {
  FrameQueue queue(Backpressure::drop_oldest);
  add_slots(queue);
  auto scan = sample_scan();
  for (Span at = 0s; at <= 3s; at += 50ms) {
    scan.stamp = Stamp{} + at;
    queue.push(test::front_scan.id, scan, scan.stamp);
  }
  const auto kept = waiting(queue);
  ASSERT_EQ(kept.size(), 21U);
  EXPECT_EQ(kept.front(), 2000);
  EXPECT_EQ(queue.dropped(), 40U);
  for (int i = 0; i < 250; ++i) queue.push(test::front_scan.id, scan, Stamp{} + 3s);
  EXPECT_EQ(waiting(queue).size(), 100U);
  EXPECT_EQ(queue.dropped(), 190U);
  for (const Span at : {10s, 15s}) queue.push(test::front_scan.id, scan, Stamp{} + at);
  EXPECT_EQ(queue.dropped(), 190U) << "of a scanner that measures seldom two wait, however old they are";
}

TEST(FrameQueue, KeepsTheOrderOfFramesAcrossTopics) {
  FrameQueue queue(Backpressure::block);
  add_slots(queue);
  auto cloud = sample_cloud(1);
  queue.push(test::roof_points.id, cloud, Stamp{1});
  queue.push(clock_slot, Stamp{2}, Stamp{2});
  queue.push(test::front_scan.id, sample_scan(), Stamp{3});
  for (int i = 1; i <= 3; ++i) {
    auto* frame = queue.pop(1ms);
    ASSERT_NE(frame, nullptr);
    EXPECT_EQ(frame->released.ns, i);
    queue.done(frame);
  }
}

TEST(FrameQueue, PassesWhatDevicesTellInOrder) {
  FrameQueue queue(Backpressure::drop_oldest);
  add_slots(queue);
  queue.push(test::roof_imu.id, DeviceMessage(test::sample_imu()), Stamp{1});
  queue.push(test::roof_fix.id, DeviceMessage(test::sample_fix()), Stamp{2});
  queue.push(test::roof_time.id, DeviceMessage(test::sample_time_reference()), Stamp{3});
  const auto next = [&queue] {
    QueuedFrame* frame = queue.pop(Span(0));
    EXPECT_NE(frame, nullptr);
    return frame;
  };
  QueuedFrame* frame = next();
  EXPECT_EQ(std::get<ImuSample>(std::get<DeviceMessage>(frame->content)).angular_velocity.z(), 0.3);
  queue.done(frame);
  frame = next();
  EXPECT_EQ(std::get<GnssFix>(std::get<DeviceMessage>(frame->content)).status, FixStatus::sbas);
  queue.done(frame);
  frame = next();
  EXPECT_EQ(std::get<TimeReference>(std::get<DeviceMessage>(frame->content)).source, "gps_pps");
  queue.done(frame);
  EXPECT_TRUE(queue.idle());
}

TEST(FrameQueue, CountsNoLatencyOverAStepThatNobodyHasNoticedYet) {
  FrameQueue queue(Backpressure::drop_oldest);
  add_slots(queue);
  constexpr Span period = 100ms, way = 3ms;
  Stamp released{1'700'000'000'000'000'000};
  const auto one_frame = [&](Span set_on_its_way) {
    queue.push(test::front_scan.id, sample_scan(), released);
    QueuedFrame* const frame = queue.pop(1ms);
    ASSERT_NE(frame, nullptr);
    queue.published(frame, released + set_on_its_way + way);
    released = released + period;
  };
  one_frame(0s);
  one_frame(-1h);
  one_frame(1h);
  const TopicFigures figures = queue.figures(test::front_scan.id, released);
  EXPECT_NEAR(figures.rate_hz, 10, 1e-9);
  EXPECT_EQ(figures.longest_gap, period);
  EXPECT_EQ(figures.longest_latency, way);
  EXPECT_EQ(figures.median_latency, way);
}

TEST(FrameQueue, LetsAnImuRunAheadFurtherThanAFrame) {
  FrameQueue queue(Backpressure::drop_oldest);
  add_slots(queue);
  for (int i = 0; i < 58; ++i) queue.push(test::roof_imu.id, DeviceMessage(test::sample_imu()), Stamp{i});
  for (int i = 0; i < 5; ++i) queue.push(test::roof_fix.id, DeviceMessage(test::sample_fix()), Stamp{i});
  EXPECT_EQ(queue.figures(test::roof_imu.id, Stamp{58}).dropped, 8U);
  EXPECT_EQ(queue.figures(test::roof_fix.id, Stamp{58}).dropped, 3U);
  QueuedFrame* oldest = queue.pop(Span(0));
  ASSERT_NE(oldest, nullptr);
  EXPECT_EQ(oldest->released.ns, 8);
  queue.done(oldest);
}

TEST(FrameQueue, LeavesTheCallerABufferForTheNextCloudAndNeedsNoNewOneAfterAWhile) {
  FrameQueue queue(Backpressure::drop_oldest);
  add_slots(queue);
  auto cloud = sample_cloud(100);
  std::set<const void*> buffers;
  for (int i = 0; i < 20; ++i) {
    const auto sent = cloud.points_bytes.size();
    buffers.insert(cloud.points_bytes.data());
    queue.push(test::roof_points.id, cloud, Stamp{i});
    cloud.points_bytes.resize(sent);
    QueuedFrame* frame = queue.pop(1ms);
    ASSERT_NE(frame, nullptr);
    EXPECT_EQ(std::get<Cloud>(frame->content).points_bytes.size(), sent);
    queue.done(frame);
  }
  EXPECT_LE(buffers.size(), 4U) << "the caller's and those of two frames that wait and one that is published";
  queue.release(test::roof_points.id);
  queue.push(test::roof_points.id, cloud, Stamp{20});
  EXPECT_EQ(cloud.points_bytes.capacity(), 0U) << "the buffers were freed";
}

TEST(FrameQueue, MakesAReplayWaitUntilThereIsRoomAndLetsItGoWhenStopped) {
  FrameQueue queue(Backpressure::block);
  add_slots(queue);
  std::atomic<int> pushed{0};
  std::thread sensor([&] {
    for (int i = 1; i <= 5; ++i) {
      queue.push(test::front_scan.id, sample_scan(), Stamp{i});
      ++pushed;
    }
  });
  const auto soon = [&](int count) {
    for (int i = 0; i < 4000 && pushed < count; ++i) std::this_thread::sleep_for(5ms);
    return pushed.load();
  };
  EXPECT_EQ(soon(2), 2);
  std::this_thread::sleep_for(50ms);
  EXPECT_EQ(pushed, 2) << "no room for a third";
  QueuedFrame* frame = queue.pop(1ms);
  ASSERT_NE(frame, nullptr);
  EXPECT_EQ(frame->released, Stamp{1});
  queue.done(frame);
  EXPECT_EQ(soon(3), 3);
  queue.stop();
  sensor.join();
  EXPECT_EQ(pushed, 5);
  EXPECT_EQ(queue.dropped(), 0U);
  EXPECT_EQ(queue.pop(1ms), nullptr) << "nothing leaves a queue that was stopped";
}

TEST(FrameQueue, CountsAFrameThatNobodyWantsAndHoldsNothingOfIt) {
  FrameQueue queue(Backpressure::drop_oldest);
  add_slots(queue);
  for (std::int64_t i = 0; i < 5; ++i) queue.skip(test::roof_points.id, Stamp{i * 100'000'000});
  const TopicFigures figures = queue.figures(test::roof_points.id, Stamp{500'000'000});
  EXPECT_EQ(figures.frames, 5U);
  EXPECT_EQ(figures.rate_hz, 10);
  EXPECT_EQ(figures.dropped, 0U);
  EXPECT_TRUE(queue.idle());
  EXPECT_EQ(queue.pop(1ms), nullptr);
}

}  // namespace
}  // namespace lidard
