// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/offline/recorded_motion.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "test/support/pipeline_bench.h"

namespace lidard {
namespace {

Stamp stamp_at(double s) { return Stamp{} + span_from_seconds(s); }

/// A second of driving along x at 1 m/s.
std::string table_of_a_drive() {
  std::string path = testing::TempDir() + "lidard-drive-" + std::to_string(getpid()) + ".csv";
  std::ofstream table(path);
  for (int i = 0; i <= 50; ++i) table << 1000 + 0.02 * i << "," << 0.02 * i << ",0,0\n";
  return path;
}

TEST(RecordedMotion, GiveTheOdometryAnewInEachRoundOfACapture) {
  test::PipelineBench bench("vehicle: {odometry_topic: odom}\nsensors: {a: {topic: s}}\n");
  MotionTable poses(table_of_a_drive(), bench.config.vehicle);
  const Stamp end = stamp_at(1001);
  for (const int round : {0, 1, 2}) {
    const Span shift = std::chrono::milliseconds(1100 * round);
    for (Stamp now = stamp_at(1000); now <= end; now = now + std::chrono::milliseconds(10))
      poses.feed(bench.pipeline, now + shift, shift);
    EXPECT_EQ(bench.value("motion", "Knots", end + shift), "51") << "in round " << round;
    bench.pipeline.finish(end + shift);
    bench.pipeline.restart();
  }
}

TEST(RecordedMotion, AreThoseOfTheCapturesTimeInEachRound) {
  test::PipelineBench bench("vehicle: {odometry_frame: odom}\nsensors: {a: {topic: s}}\n");
  MotionTable poses(table_of_a_drive(), bench.config.vehicle);
  for (const int round : {0, 1, 2}) {
    const Span shift = std::chrono::seconds(10 * round);
    const Stamp middle = stamp_at(1000.5) + shift;
    poses.feed(bench.pipeline, middle, shift);
    Pose pose;
    std::string why;
    ASSERT_TRUE(poses.lookup("odom", "base_link", middle, pose, why)) << why;
    EXPECT_NEAR(pose.translation().x(), 0.5, 1e-6);
    std::vector<StampedPose> track;
    poses.history("odom", "base_link", middle, middle + std::chrono::milliseconds(100), track);
    ASSERT_FALSE(track.empty()) << "in round " << round;
    EXPECT_NEAR(track.back().pose.translation().x(), 0.6, 1e-6);
    EXPECT_NEAR(seconds(track.back().stamp - middle), 0.1, 1e-6);
  }
}

}  // namespace
}  // namespace lidard
