// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/frame_queue.h"

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

TEST(FrameQueue, DropsTheOldestAndCountsItWhenTheSensorThreadIsFaster) {
  FrameQueue queue({{"a", TopicKind::scan}, {"b", TopicKind::cloud}}, Backpressure::drop_oldest);
  auto scan = sample_scan();
  for (int i = 1; i <= 5; ++i) {
    scan.stamp.ns = i;
    EXPECT_TRUE(queue.push("a", scan, Stamp{i}));
  }
  EXPECT_FALSE(queue.push("b", scan, Stamp{1})) << "a scan on a cloud's topic";
  EXPECT_FALSE(queue.push("unknown", scan, Stamp{1}));
  EXPECT_EQ(queue.dropped(0), 3U);
  auto* first = queue.pop(1ms);
  ASSERT_NE(first, nullptr);
  EXPECT_EQ(std::get<PlanarScan>(first->content).stamp.ns, 4);
  queue.done(first);
  EXPECT_FALSE(queue.idle());
  auto* second = queue.pop(1ms);
  ASSERT_NE(second, nullptr);
  EXPECT_EQ(std::get<PlanarScan>(second->content).stamp.ns, 5);
  queue.done(second);
  EXPECT_TRUE(queue.idle());
  EXPECT_EQ(queue.pop(1ms), nullptr);
}

TEST(FrameQueue, KeepsTheOrderOfFramesAcrossTopics) {
  FrameQueue queue({{"a", TopicKind::scan}, {"b", TopicKind::cloud}}, Backpressure::block);
  auto cloud = sample_cloud(1);
  queue.push("b", cloud, Stamp{1});
  queue.push_clock(Stamp{2});
  queue.push("a", sample_scan(), Stamp{3});
  for (int i = 1; i <= 3; ++i) {
    auto* frame = queue.pop(1ms);
    ASSERT_NE(frame, nullptr);
    EXPECT_EQ(frame->released.ns, i);
    queue.done(frame);
  }
}

TEST(FrameQueue, PassesWhatDevicesTellInOrder) {
  FrameQueue queue({{"roof/fix", TopicKind::fix},
                    {"roof/time_reference", TopicKind::time_reference},
                    {"roof/imu", TopicKind::imu}},
                   Backpressure::drop_oldest);
  EXPECT_TRUE(queue.push("roof/imu", test::sample_imu(), Stamp{1}));
  EXPECT_TRUE(queue.push("roof/fix", test::sample_fix(), Stamp{2}));
  EXPECT_TRUE(queue.push("roof/time_reference", test::sample_time_reference(), Stamp{3}));
  EXPECT_FALSE(queue.push("roof/imu", test::sample_fix(), Stamp{4})) << "another kind of topic";
  EXPECT_FALSE(queue.push("roof/imu", test::sample_scan(), Stamp{4}));
  EXPECT_FALSE(queue.push("roof/nothing", test::sample_imu(), Stamp{4}));
  const auto next = [&queue] {
    QueuedFrame* frame = queue.pop(Span(0));
    EXPECT_NE(frame, nullptr);
    return frame;
  };
  QueuedFrame* frame = next();
  EXPECT_EQ(std::get<ImuSample>(frame->content).angular_velocity.z(), 0.3);
  queue.done(frame);
  frame = next();
  EXPECT_EQ(std::get<GnssFix>(frame->content).status, FixStatus::sbas);
  queue.done(frame);
  frame = next();
  EXPECT_EQ(std::get<TimeReference>(frame->content).source, "gps_pps");
  queue.done(frame);
  EXPECT_TRUE(queue.idle());
}

TEST(FrameQueue, LetsAnImuRunAheadFurtherThanAFrame) {
  FrameQueue queue({{"roof/imu", TopicKind::imu}, {"roof/fix", TopicKind::fix}}, Backpressure::drop_oldest);
  for (int i = 0; i < 40; ++i) queue.push("roof/imu", test::sample_imu(), Stamp{i});
  for (int i = 0; i < 5; ++i) queue.push("roof/fix", test::sample_fix(), Stamp{i});
  EXPECT_EQ(queue.dropped(0), 8U);
  EXPECT_EQ(queue.dropped(1), 3U);
  QueuedFrame* oldest = queue.pop(Span(0));
  ASSERT_NE(oldest, nullptr);
  EXPECT_EQ(oldest->released.ns, 8);
  queue.done(oldest);
}

TEST(FrameQueue, LeavesTheCallerABufferForTheNextCloudAndNeedsNoNewOneAfterAWhile) {
  FrameQueue queue({{"roof/points", TopicKind::cloud}}, Backpressure::drop_oldest);
  auto cloud = sample_cloud(100);
  std::set<const void*> buffers;
  for (int i = 0; i < 20; ++i) {
    const auto sent = cloud.points_bytes.size();
    buffers.insert(cloud.points_bytes.data());
    ASSERT_TRUE(queue.push("roof/points", cloud, Stamp{i}));
    if (cloud.points_bytes.capacity() < sent) cloud.points_bytes.reserve(sent);
    cloud.points_bytes.resize(sent);
    QueuedFrame* frame = queue.pop(1ms);
    ASSERT_NE(frame, nullptr);
    EXPECT_EQ(std::get<Cloud>(frame->content).points_bytes.size(), sent);
    queue.done(frame);
  }
  EXPECT_LE(buffers.size(), 4U) << "the caller's and those of two frames that wait and one that is published";
}

TEST(FrameQueue, MakesAReplayWaitUntilThereIsRoomAndLetsItGoWhenStopped) {
  FrameQueue queue({{"a", TopicKind::scan}}, Backpressure::block);
  std::atomic<int> pushed{0};
  std::thread sensor([&] {
    for (int i = 1; i <= 5; ++i) {
      queue.push("a", sample_scan(), Stamp{i});
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

}  // namespace
}  // namespace lidard
