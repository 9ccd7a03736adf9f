// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Segments that are lost, late or overtaken, and the times that a scan or a cloud then has.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "drivers/capture/pcap_source.h"
#include "drivers/registry/registry.h"
#include "test/drivers/sick/compact/segment_bench.h"
#include "test/support/captures.h"
#include "test/support/collector.h"

namespace lidard::test {
namespace {

TEST(SegmentTimes, ScanTimeIsTheTurnsAlsoOverALostFrame) {
  SegmentBench bench;
  for (const std::uint64_t frame : {0U, 1U, 2U, 3U, 6U, 7U, 9U, 10U}) bench.send_frame(frame);
  ASSERT_GE(bench.scans.size(), 6U);
  for (std::size_t i = 0; i < bench.scans.size(); ++i) {
    EXPECT_NEAR(bench.scans[i].scan_time, 0.05, 2e-5) << i;
    EXPECT_NEAR(bench.scans[i].time_increment, 0.05 / 720, 1e-8) << i;
  }
}

TEST(SegmentTimes, ASpoiledSegmentChangesTheTimesOfNoOtherScan) {
  LIDARD_NEED_CAPTURE(path, "sick/picoscan150_compact_frag.pcap");
  const auto decode = [&](std::optional<std::size_t> spoiled) {
    DriverConfig config;
    config.model = find_model("sick_picoscan150");
    config.frame_id = "laser";
    const auto driver = config.model->make(config);
    Collector out;
    PcapSource source(path);
    std::size_t number = 0;
    for (Packet packet; source.next(packet); ++number) {
      std::vector<std::uint8_t> bytes(packet.payload.begin(), packet.payload.end());
      if (number == spoiled) bytes[bytes.size() / 2] ^= 0x55U;
      packet.payload = {bytes.data(), bytes.size()};
      driver->receive(packet, out);
    }
    driver->finish(out);
    return out.scans;
  };
  const auto whole = decode(std::nullopt);
  for (std::size_t spoiled = 40; spoiled < 50; ++spoiled) {
    const auto damaged = decode(spoiled);
    ASSERT_EQ(damaged.size(), whole.size());
    std::size_t others = 0;
    for (std::size_t i = 0; i < whole.size(); ++i) {
      const bool same =
          damaged[i].scan_time == whole[i].scan_time && damaged[i].time_increment == whole[i].time_increment;
      others += same ? 0U : 1U;
    }
    EXPECT_LE(others, 1U) << "segment " << spoiled;
  }
}

TEST(SegmentTimes, ASampleThatComesSoonerThanScansDoIsNotStampedAfterItsArrival) {
  SegmentBench bench("sick_multiscan136");
  for (std::uint64_t frame = 0; frame < 4; ++frame) bench.send_frame(frame);
  const std::uint64_t us = bench.time_us(4, 0);
  const auto send = [&](Span after) {
    bench.send(sim::compact_imu(us, {}, {}, {}), bench.host_of(us) + after, 7503);
    return bench.imus.back().stamp - bench.host_of(us);
  };
  EXPECT_EQ(send(std::chrono::microseconds(500)), std::chrono::microseconds(500));
  EXPECT_NEAR(seconds(send(std::chrono::milliseconds(9))), 2e-3, 0.2e-3) << "what scans take at least";
}

/// The clouds of one device whose segments come in the order that `order` gives within each frame.
std::vector<Cloud> clouds_in_order(const std::vector<int>& order) {
  SegmentBench bench("sick_multiscan136");
  for (std::uint64_t frame = 0; frame < 5; ++frame) {
    // All of a frame comes in one burst, behind its last beam.
    Stamp arrival = bench.arrival(frame, SegmentBench::segments - 1);
    for (const int index : order) {
      bench.send(bench.encode(bench.segment(frame, index)), arrival);
      arrival = arrival + std::chrono::microseconds(10);
    }
  }
  return bench.clouds;
}

/// The points of a cloud in an order of their own.
std::vector<std::array<float, 4>> sorted_points(const Cloud& cloud) {
  std::vector<std::array<float, 4>> points;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const CloudPoint p = cloud.points()[i];
    points.push_back({p.x, p.y, p.z, p.time});
  }
  std::sort(points.begin(), points.end());
  return points;
}

// Datagrams overtake each other on their way; the beams were measured when they were all the same.
TEST(SegmentTimes, BeginAndEndOfACloudDoNotDependOnTheOrderInWhichItsSegmentsCome) {
  const std::vector<int> straight{0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
  const auto expected = clouds_in_order(straight);
  ASSERT_GE(expected.size(), 2U);
  const std::vector<std::vector<int>> orders{{0, 1, 2, 3, 4, 5, 6, 7, 9, 8},
                                             {1, 0, 2, 3, 4, 5, 6, 7, 8, 9},
                                             {0, 2, 1, 3, 5, 4, 6, 7, 9, 8},
                                             {3, 0, 1, 2, 4, 5, 6, 9, 7, 8}};
  for (const auto& order : orders) {
    const auto clouds = clouds_in_order(order);
    ASSERT_EQ(clouds.size(), expected.size());
    for (std::size_t i = 1; i < clouds.size(); ++i) {
      EXPECT_NEAR(seconds(clouds[i].stamp - expected[i].stamp), 0, 1e-3) << order[0] << order[9];
      EXPECT_NEAR(seconds(clouds[i].end - clouds[i].stamp), seconds(expected[i].end - expected[i].stamp),
                  1e-6);
      const auto is = sorted_points(clouds[i]), should = sorted_points(expected[i]);
      ASSERT_EQ(is.size(), should.size());
      for (std::size_t k = 0; k < is.size(); ++k) {
        EXPECT_EQ(is[k][0], should[k][0]);
        EXPECT_NEAR(is[k][3], should[k][3], 1e-6) << "time of point " << k;
        EXPECT_GE(is[k][3], 0);
      }
    }
  }
}

TEST(SegmentTimes, EndOfACloudIsThatOfItsLastBeam) {
  const auto clouds = clouds_in_order({0, 1, 2, 3, 4, 5, 6, 7, 8, 9});
  ASSERT_GE(clouds.size(), 2U);
  for (const Cloud& cloud : clouds) {
    EXPECT_NEAR(seconds(cloud.end - cloud.stamp), 552 * 50e-3 / 720, 2e-6);
    float latest = 0;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const float time = cloud.points()[i].time;
      latest = std::max(latest, time);
    }
    EXPECT_NEAR(static_cast<double>(latest), seconds(cloud.end - cloud.stamp), 2e-6);
  }
}

TEST(SegmentClouds, LeaveOutWhatIsNearerOrFartherThanConfigured) {
  for (const bool inside : {false, true}) {
    DriverConfig config;
    config.min_range = inside ? 2.0 : 2.0005;
    config.max_range = inside ? 2.552 : 2.5515;
    SegmentBench bench("sick_multiscan136", config);
    for (std::uint64_t frame = 0; frame < 3; ++frame) bench.send_frame(frame);
    ASSERT_FALSE(bench.clouds.empty());
    EXPECT_EQ(bench.clouds[0].size(), inside ? 553U : 551U);
  }
}

TEST(SegmentClouds, KeepWhatLiesInTheViewAroundItsDirection) {
  for (const double direction : {0.0, 1.0, -2.0, 3.1}) {
    DriverConfig config;
    config.view_direction = direction;
    config.view_width = 0.8;
    SegmentBench bench("sick_multiscan136", config);
    for (std::uint64_t frame = 0; frame < 3; ++frame) bench.send_frame(frame);
    ASSERT_FALSE(bench.clouds.empty());
    const Cloud& cloud = bench.clouds[0];
    std::size_t expected = 0;
    for (int beam = 0; beam < 553; ++beam) {
      const double azimuth = (-138 + 0.5 * beam) * bench_rad;
      if (std::abs(std::remainder(azimuth - direction, 2 * M_PI)) <= 0.4) ++expected;
    }
    EXPECT_NEAR(static_cast<double>(cloud.size()), static_cast<double>(expected), 1.0) << direction;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const CloudPoint p = cloud.points()[i];
      const double azimuth = std::atan2(static_cast<double>(p.y), static_cast<double>(p.x));
      EXPECT_LE(std::abs(std::remainder(azimuth - direction, 2 * M_PI)), 0.4 + 1e-6);
    }
  }
}

TEST(SegmentLosses, ASegmentThatComesTwiceOrTooLateIsNamedSo) {
  SegmentBench bench;
  for (std::uint64_t frame = 0; frame < 4; ++frame) bench.send_frame(frame, frame == 2 ? 5 : -1);
  const auto before = bench.driver->counters();
  bench.send(4, 0);
  bench.send(4, 1);
  EXPECT_EQ(bench.send(4, 1), Reject::duplicate);
  EXPECT_EQ(bench.send(2, 5), Reject::stale);
  for (int i = 2; i < SegmentBench::segments; ++i) bench.send(4, i);
  const auto& after = bench.driver->counters();
  EXPECT_EQ(after.frames, before.frames + 1);
  EXPECT_EQ(after.rejected_total(), before.rejected_total() + 2);
  EXPECT_EQ(before.lost_packets, 1U);
  EXPECT_EQ(after.lost_packets, 0U) << "it was late, and not lost";
}

}  // namespace
}  // namespace lidard::test
