// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/tf_poses.h"

#include <tf2_ros/transform_listener.h>

#include "daemon/ros/ros_callback_thread.h"
#include "daemon/ros/tf_history.h"

namespace lidard {
namespace {

/// How long transforms are kept; frames are looked up at most some hundred milliseconds after they were
/// measured.
constexpr double kept_s = 10;

}  // namespace

TfPoses::TfPoses() : buffer_(std::make_shared<tf2::BufferCore>(ros::Duration(kept_s))) {}

bool TfPoses::lookup(const std::string& parent, const std::string& child, Stamp stamp, Pose& pose,
                     std::string& why_not) {
  if (look_up(*buffer_, parent, child, stamp + step_, pose, why_not)) return true;
  if (!listening_) why_not = "no tf: there was no ROS master yet; publish it on tf or configure the pose";
  return false;
}

void TfPoses::history(const std::string& parent, const std::string& child, Stamp after, Stamp until,
                      std::vector<StampedPose>& poses) {
  const std::size_t known = poses.size();
  read_history(*buffer_, parent, child, after + step_, until + step_, poses);
  for (std::size_t i = known; i < poses.size(); ++i) poses[i].stamp = poses[i].stamp - step_;
}

void TfPoses::connected(RosCallbackThread& ros) {
  constexpr bool own_thread = false;
  ros.keep(std::make_shared<tf2_ros::TransformListener>(*buffer_, ros.node(), own_thread));
  listening_ = true;
}

}  // namespace lidard
