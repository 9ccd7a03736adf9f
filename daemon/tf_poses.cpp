// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/tf_poses.h"

#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include <atomic>
#include <utility>
#include <vector>

#include "daemon/ros_convert.h"

namespace lidard {
namespace {

/// How long transforms are kept; frames are looked up at most some hundred milliseconds after they were
/// measured.
constexpr double kept_s = 10;

Pose to_pose(const geometry_msgs::Transform& transform) {
  const auto& t = transform.translation;
  const auto& q = transform.rotation;
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized().toRotationMatrix();
  pose.translation() = Eigen::Vector3d(t.x, t.y, t.z);
  return pose;
}

}  // namespace

bool NoPoses::lookup(const std::string& parent, const std::string& child, Stamp, Pose&,
                     std::string& why_not) {
  why_not = "the pose of " + child + " in " + parent + " would come from tf, which needs ROS; configure it";
  return false;
}

struct TfPoses::Impl {
  // Shared with a listener that is left running when the master hangs at the end.
  std::shared_ptr<tf2_ros::Buffer> buffer = std::make_shared<tf2_ros::Buffer>(ros::Duration(kept_s), false);
  std::unique_ptr<tf2_ros::TransformListener> listener;
  std::atomic<bool> listening{false};
};

TfPoses::TfPoses() : impl_(std::make_unique<Impl>()) {}
TfPoses::~TfPoses() = default;

bool TfPoses::lookup(const std::string& parent, const std::string& child, Stamp stamp, Pose& pose,
                     std::string& why_not) {
  const std::string to = ros_frame(parent);
  const std::string from = ros_frame(child);
  if (to.empty() || from.empty()) {
    why_not = "a frame name is empty";
    return false;
  }
  if (to == from) {
    pose = Pose::Identity();
    return true;
  }
  const ros::Time time = to_ros(stamp);
  // Asked first, because lookupTransform() throws, and an unknown pose is an everyday matter.
  const tf2::BufferCore& buffer = *impl_->buffer;
  why_not.clear();
  if (!buffer.canTransform(to, from, time, &why_not)) {
    if (!impl_->listening) why_not = "no tf: there was no ROS master yet";
    if (why_not.empty()) why_not = "tf does not know " + from + " in " + to;
    why_not += "; publish it on tf or configure the pose";
    return false;
  }
  try {
    pose = to_pose(buffer.lookupTransform(to, from, time).transform);
  } catch (const tf2::TransformException& problem) {
    why_not = problem.what();
    return false;
  }
  return true;
}

void TfPoses::connected() {
  impl_->listener = std::make_unique<tf2_ros::TransformListener>(*impl_->buffer);
  impl_->listening = true;
}

void TfPoses::disconnected(bool leave) {
  impl_->listening = false;
  if (leave) {
    static auto* const left = new std::vector<
        std::pair<std::shared_ptr<tf2_ros::Buffer>, std::unique_ptr<tf2_ros::TransformListener>>>;
    left->emplace_back(impl_->buffer, std::move(impl_->listener));
  }
  impl_->listener.reset();
}

}  // namespace lidard
