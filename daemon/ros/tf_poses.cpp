// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/tf_poses.h"

#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include <atomic>
#include <utility>
#include <vector>

#include "daemon/pipeline/transform_source.h"
#include "daemon/ros/tf_history.h"

namespace lidard {
namespace {

/// How long transforms are kept; frames are looked up at most some hundred milliseconds after they were
/// measured.
constexpr double kept_s = 10;

}  // namespace

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
  if (look_up(*impl_->buffer, parent, child, stamp, pose, why_not)) return true;
  if (!impl_->listening)
    why_not = "no tf: there was no ROS master yet; publish it on tf or configure the pose";
  return false;
}

void TfPoses::history(const std::string& parent, const std::string& child, Stamp after, Stamp until,
                      std::vector<StampedPose>& poses) {
  read_history(*impl_->buffer, parent, child, after, until, poses);
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
