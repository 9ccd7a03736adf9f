// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Messages of other drivers: the frame that they name, and the pose that is configured for their topic.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "test/support/pipeline_bench.h"

namespace lidard {
namespace {

using test::PipelineBench;

constexpr Stamp begin{1'700'000'000'000'000'000};

/// A scan of a wall 2 m ahead of `frame`, as another driver's message.
PlanarScan foreign_scan(const std::string& frame) {
  PlanarScan scan;
  scan.reset(3);
  scan.set_angles(-0.01F, 0.01F);
  scan.range_max = 10;
  for (std::size_t beam = 0; beam < scan.beams; ++beam) scan.set_hit(beam, 2);
  scan.frame_id = frame;
  scan.stamp = begin;
  return scan;
}

TEST(ForeignFrames, AConfiguredPoseCountsWhateverFrameTheMessagesName) {
  for (const char* frame : {"a", "laser_of_another_driver", "base_link", ""}) {
    PipelineBench bench(
        "sensors: {a: {topic: /a, pose: {xyz: [1, 0, 0.5], rpy_deg: [0, 0, 90]}}}\n"
        "merged_scans: {m: {laserscan_topics: a, beams: 360, range_max: 9}}\n");
    PlanarScan scan = foreign_scan(frame);
    bench.give("a", scan, begin);
    ASSERT_EQ(bench.sink.scans["m"].size(), 1U) << frame << ": " << why_missing(bench.pipeline, "m");
    const PlanarScan& merged = bench.sink.scans["m"][0];
    // From base_link the hit stands at (1, 2): 63.4 deg to the left, 2.236 m away.
    const auto nearest = std::min_element(merged.ranges.begin(), merged.ranges.end());
    EXPECT_NEAR(static_cast<double>(*nearest), std::sqrt(5), 0.03) << frame;
    const auto beam = static_cast<std::size_t>(nearest - merged.ranges.begin());
    EXPECT_NEAR(static_cast<double>(merged.angle(beam)), std::atan2(2, 1), 0.02) << frame;
  }
}

TEST(ForeignFrames, SweepOfASourceWithoutPoseIsCountedAndItsFrameNamed) {
  // The frame alone is no pose: what the messages name has to be known to tf.
  PipelineBench bench(
      "sensors: {a: {topic: /a, frame_id: base_link}, b: {topic: /b, pose: {xyz: [0, 0, 0]}}}\n"
      "merged_scans: {m: {laserscan_topics: [a, b], beams: 360, range_max: 9}}\n");
  PlanarScan scan = foreign_scan("unheard_of");
  bench.give("a", scan, begin);
  bench.pipeline.tick(begin + std::chrono::seconds(2));
  const auto& item = bench.sink.item("merged m");
  EXPECT_EQ(item.health, Health::error);
  EXPECT_NE(item.message.find("unheard_of"), std::string::npos) << item.message;
}

TEST(ForeignFrames, AScannerMayHaveTheNameOfAVirtualScan) {
  PipelineBench bench(
      "sensors: {bumper: {topic: /front, frame_id: laser, pose: {xyz: [0, 0, 0]}}, roof: {topic: /roof, "
      "pose: {xyz: [0, 0, "
      "2]}}}\n"
      "virtual_scans: {v: {cloud_topic: roof, virtual_laser_scan: bumper, poses: {bumper: {xyz: [5, 0, "
      "0]}}}}\n"
      "merged_scans: {m: {laserscan_topics: /front, beams: 360, range_max: 9}}\n");
  Cloud cloud;
  cloud.frame_id = "roof";
  cloud.stamp = cloud.end = begin;
  bench.give("roof", cloud, begin);
  EXPECT_EQ(bench.sink.scans["bumper"].size(), 1U);
  EXPECT_EQ(bench.sink.scans["m"].size(), 0U) << "the virtual scan was taken for the scanner";
  PlanarScan scan = foreign_scan("bumper");
  bench.give("bumper", scan, begin);
  EXPECT_EQ(bench.sink.scans["m"].size(), 1U);
}

TEST(ForeignFrames, AConfiguredPoseCountsWhateverFrameTheCloudsNameAndAFrameWithoutPoseIsNamed) {
  PipelineBench bench(
      "sensors: {roof: {topic: /roof, pose: {xyz: [0, 0, 2]}}}\n"
      "virtual_scans: {v: {cloud_topic: roof, virtual_laser_scan: [low, nowhere], poses: {low: {xyz: [0, 0, "
      "0.5]}}}}\n");
  Cloud cloud;
  cloud.frame_id = "velodyne";
  cloud.stamp = cloud.end = begin;
  cloud.points_bytes.resize(sizeof(CloudPoint));
  cloud.points()[0] = CloudPoint{3, 0, -1.5F, 1, 0, 0};
  bench.give("roof", cloud, begin);
  bench.pipeline.tick(begin + std::chrono::seconds(1));
  ASSERT_EQ(bench.sink.scans["low"].size(), 1U);
  const PlanarScan& low = bench.sink.scans["low"][0];
  EXPECT_NEAR(static_cast<double>(*std::min_element(low.ranges.begin(), low.ranges.end())), 3, 1e-3);
  EXPECT_EQ(bench.sink.scans["nowhere"].size(), 0U);
  EXPECT_EQ(bench.sink.item("virtual v").health, Health::warn);
  EXPECT_EQ(bench.sink.item("virtual v").message.rfind("publishing without nowhere: ", 0), 0U)
      << bench.sink.item("virtual v").message;
}

}  // namespace
}  // namespace lidard
