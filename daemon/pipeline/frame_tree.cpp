// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/frame_tree.h"

namespace lidard {

FrameTree::FrameTree(const Config& config, TransformSource& lookup)
    : base_(config.vehicle.base_frame), lookup_(lookup) {
  for (const auto& sensor : config.sensors) {
    if (sensor.pose) add(base_, sensor.frame_id, *sensor.pose);
  }
  for (const auto& merged : config.merged_scans) {
    if (merged.destination_pose) add(base_, merged.destination_frame, *merged.destination_pose);
  }
  for (const auto& group : config.virtual_scans) {
    for (const auto& [frame, pose] : group.poses) add(group.base_frame, frame, pose);
  }
}

void FrameTree::add(const std::string& parent, const std::string& child, const Pose& pose) {
  // A frame has one parent (REP 105); the first entry that names it counts.
  if (child == parent || !known_.emplace(child, std::make_pair(parent, pose)).second) return;
  transforms_.push_back({parent, child, pose});
}

bool FrameTree::in_base(const std::string& frame, Stamp stamp, Pose& pose, std::string& why_not) const {
  pose = Pose::Identity();
  std::string at = frame;
  // Configured poses form chains of at most two links (virtual frame, its base frame); longer ones are tf's
  // business.
  for (int links = 0; links < 4 && at != base_; ++links) {
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
