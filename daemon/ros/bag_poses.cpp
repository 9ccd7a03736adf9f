// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/bag_poses.h"

#include <nav_msgs/Odometry.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <stdexcept>

#include "daemon/pipeline/pipeline.h"
#include "daemon/ros/ros_convert.h"
#include "daemon/ros/tf_history.h"

namespace lidard {
namespace {

// The whole of any bag is kept.
constexpr double kept_s = 1e7;

}  // namespace

struct BagPoses::Impl {
  tf2::BufferCore buffer{ros::Duration(kept_s)};

  void take(const tf2_msgs::TFMessage& message, bool fixed) {
    for (const auto& transform : message.transforms) buffer.setTransform(transform, "bag", fixed);
  }
};

BagPoses::BagPoses(const std::string& path, const std::string& odometry_topic)
    : impl_(path.empty() ? nullptr : std::make_unique<Impl>()) {
  if (path.empty()) return;
  try {
    rosbag::Bag bag(path, rosbag::bagmode::Read);
    for (const auto& message : rosbag::View(bag)) {
      const std::string topic = message.getTopic();
      if (const auto tf = message.instantiate<tf2_msgs::TFMessage>())
        impl_->take(*tf, topic == "/tf_static" || topic == "tf_static");
      if (odometry_topic.empty() || (topic != odometry_topic && topic != "/" + odometry_topic)) continue;
      const auto odometry = message.instantiate<nav_msgs::Odometry>();
      if (!odometry) throw std::runtime_error("topic " + topic + " is no nav_msgs/Odometry");
      const auto& pose = odometry->pose.pose;
      odometry_.push_back({from_ros(odometry->header.stamp), to_pose(pose.position, pose.orientation)});
      child_ = odometry->child_frame_id;
    }
  } catch (const std::exception& problem) {
    throw std::runtime_error(path + ": " + problem.what() + "; expected a bag with /tf or the odometry");
  }
  std::stable_sort(odometry_.begin(), odometry_.end(),
                   [](const StampedPose& a, const StampedPose& b) { return a.stamp < b.stamp; });
}

BagPoses::~BagPoses() = default;

bool BagPoses::lookup(const std::string& parent, const std::string& child, Stamp stamp, Pose& pose,
                      std::string& why_not) {
  if (!impl_) return NoTransforms().lookup(parent, child, stamp, pose, why_not);
  return look_up(impl_->buffer, parent, child, stamp, pose, why_not);
}

void BagPoses::history(const std::string& parent, const std::string& child, Stamp after, Stamp until,
                       std::vector<StampedPose>& poses) {
  if (impl_) read_history(impl_->buffer, parent, child, after, until, poses);
}

void BagPoses::feed(Pipeline& pipeline, Stamp until) {
  for (; next_ < odometry_.size() && odometry_[next_].stamp <= until; ++next_) {
    const auto& [stamp, pose] = odometry_[next_];
    pipeline.pose_message(stamp, pose, child_, stamp);
  }
}

}  // namespace lidard
