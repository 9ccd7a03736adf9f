// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Frames of a device whose clock or counters jump.
#include "test/drivers/sick/compact/segment_bench.h"

namespace lidard::sick {
namespace {

using namespace lidard::test;

TEST(FrameBuilder, ARestartOfTheDeviceStampsRightAtOnce) {
  SegmentBench bench;
  for (std::uint64_t f = 0; f < 50; ++f) bench.send_frame(f);
  const std::size_t before = bench.scans.size();
  bench.start_us = 3'000'000;
  bench.epoch = bench.epoch + std::chrono::seconds(20);
  for (std::uint64_t f = 0; f < 5; ++f) {
    for (int i = 0; i < SegmentBench::segments; ++i) {
      sim::SickSegment segment = bench.segment(f, i);
      segment.counter -= 999;
      segment.frame -= 70;
      bench.send(bench.encode(segment), bench.arrival(f, i));
    }
  }
  ASSERT_EQ(bench.scans.size(), before + 5);
  for (std::uint64_t f = 0; f < 5; ++f) {
    const Stamp first = bench.host_of(bench.time_us(f, 0)) + std::chrono::milliseconds(2);
    EXPECT_NEAR(seconds(bench.scans[before + f].stamp - first), 0, 1e-5);
    expect_geometry(bench.scans[before + f]);
  }
  EXPECT_EQ(bench.driver->counters().lost_packets, 0U);
  EXPECT_EQ(bench.driver->counters().clock_steps, 1U);
}

TEST(FrameBuilder, AClockThatIsSetBackALittleTearsOneFrameAlone) {
  for (const std::uint64_t back_us : {100'000U, 1'000'000U, 1'900'000U}) {
    SegmentBench bench;
    for (std::uint64_t f = 0; f < 50; ++f) bench.send_frame(f);
    const std::size_t before = bench.scans.size();
    bench.start_us -= back_us;
    for (std::uint64_t f = 50; f < 100; ++f) {
      for (int i = 0; i < SegmentBench::segments; ++i) {
        bench.driver->tick(bench.arrival(f, i), bench);
        bench.send(f, i);
      }
    }
    EXPECT_GE(bench.scans.size(), before + 49) << back_us;
    std::size_t torn = 0;
    for (std::size_t i = before; i < bench.scans.size(); ++i) {
      EXPECT_EQ(bench.scans[i].beams, SegmentBench::all_beams) << back_us;
      if (unobserved(bench.scans[i]) > 0) ++torn;
    }
    EXPECT_LE(torn, 1U) << back_us;
    EXPECT_EQ(bench.driver->counters().rejected_total(), 0U) << back_us;
  }
}

TEST(FrameBuilder, FramesThatAreCountedAnewGoOnThoughTimeAndTelegramsDo) {
  SegmentBench bench;
  for (std::uint64_t f = 0; f < 200; ++f) bench.send_frame(f);
  const std::size_t before = bench.scans.size();
  for (std::uint64_t f = 200; f < 205; ++f) {
    for (int i = 0; i < SegmentBench::segments; ++i) {
      sim::SickSegment segment = bench.segment(f, i);
      segment.frame -= 199;
      bench.send(bench.encode(segment), bench.arrival(f, i));
    }
  }
  EXPECT_GE(bench.scans.size(), before + 4);
  EXPECT_EQ(bench.driver->counters().rejected_total(), 0U);
}

}  // namespace
}  // namespace lidard::sick
