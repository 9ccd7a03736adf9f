// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/motion/frame_tree.h"

namespace lidard {

void FrameTree::configure(std::string base, std::vector<StaticTransform> fixed) {
  base_ = std::move(base);
  fixed_ = std::move(fixed);
  known_.clear();
  for (const StaticTransform& one : fixed_) known_.emplace(one.child, std::make_pair(one.parent, one.pose));
}

bool FrameTree::in_base(const std::string& frame, Stamp stamp, Pose& pose, std::string& why_not) const {
  pose = Pose::Identity();
  std::string at = frame;
  // Fixed poses form chains of at most two transforms (virtual frame, its base frame); longer ones come
  // from tf.
  for (int length = 0; length < 4 && at != base_; ++length) {
    const auto entry = known_.find(at);
    if (entry == known_.end()) break;
    pose = entry->second.second * pose;
    at = entry->second.first;
  }
  if (at == base_) return true;
  Pose rest = Pose::Identity();
  if (!lookup_.lookup(base_, at, stamp, rest, why_not)) return false;
  pose = rest * pose;
  return true;
}

bool FrameTree::find(const std::string& parent, const std::string& child, Stamp stamp, Pose& pose,
                     std::string& why_not) const {
  if (parent == child) {
    pose = Pose::Identity();
    return true;
  }
  Pose base_parent = Pose::Identity();
  Pose base_child = Pose::Identity();
  if (!in_base(parent, stamp, base_parent, why_not) || !in_base(child, stamp, base_child, why_not))
    return false;
  pose = base_parent.inverse() * base_child;
  return true;
}

}  // namespace lidard
