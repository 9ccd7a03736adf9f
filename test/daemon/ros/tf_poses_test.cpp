// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/in/tf_poses.h"

#include <geometry_msgs/TransformStamped.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "test/support/pipeline_bench.h"

namespace lidard {
namespace {

/// tf of a vehicle that drives along x, without the ROS that fills it.
class DrivenPoses final : public BufferPoses {
 public:
  explicit DrivenPoses(SharedClockStep clock) : BufferPoses(10, std::move(clock)) {}
  void publish(double host_s, double x) {
    geometry_msgs::TransformStamped message;
    message.header.stamp = ros::Time(host_s);
    message.header.frame_id = "odom";
    message.child_frame_id = "base_link";
    message.transform.translation.x = x;
    message.transform.rotation.w = 1;
    buffer_.setTransform(message, "test");
  }
  void clear() { buffer_.clear(); }
  std::vector<StampedPose> news(double after_s, double until_s) {
    std::vector<StampedPose> poses;
    history("odom", "base_link", stamp(after_s), stamp(until_s), poses);
    return poses;
  }
  static Stamp stamp(double s) { return Stamp{} + span_from_seconds(s); }
};

TEST(BufferPoses, AStepOfTheHostsClockBackRepeatsNoOldPoses) {
  const auto clock = std::make_shared<ClockStep>();
  DrivenPoses tf(clock);
  for (int i = 0; i <= 50; ++i) tf.publish(1000 + 0.02 * i, 0.1 * i);
  const auto before = tf.news(1000.5, 1001);
  ASSERT_FALSE(before.empty());
  EXPECT_NEAR(before.back().pose.translation().x(), 5, 1e-6);
  // 1 s back; tf still holds what was published before.
  clock->set(std::chrono::seconds(-1));
  EXPECT_TRUE(tf.news(1001, 1001.02).empty());
  // With the next message tf2's listener has seen the step, too.
  tf.clear();
  for (int i = 1; i <= 3; ++i) tf.publish(1000 + 0.02 * i, 5 + 0.1 * i);
  const auto after = tf.news(1001, 1001.06);
  ASSERT_FALSE(after.empty());
  for (const StampedPose& one : after) {
    const double s = seconds(one.stamp - Stamp{});
    EXPECT_NEAR(one.pose.translation().x(), 5 + 5 * (s - 1001), 1e-6) << s;
  }
}

}  // namespace
}  // namespace lidard
