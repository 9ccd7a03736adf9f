// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/tf_history.h"

#include <tf2/exceptions.h>

#include <algorithm>

#include "daemon/pipeline/transform_source.h"
#include "daemon/ros/ros_convert.h"

namespace lidard {
namespace {

// Between such samples of tf, which itself draws straight lines between its knots, a vehicle's way is
// straight.
constexpr Span sampling = std::chrono::milliseconds(10);
constexpr Span shortest_step = std::chrono::milliseconds(5);
// What a merge may need of the past.
constexpr Span longest_past = std::chrono::seconds(2);

bool sample(const tf2::BufferCore& buffer, const std::string& to, const std::string& from, Stamp stamp,
            std::vector<StampedPose>& poses) {
  const ros::Time time = to_ros(stamp);
  if (!buffer.canTransform(to, from, time)) return false;
  poses.push_back({stamp, to_pose(buffer.lookupTransform(to, from, time).transform)});
  return true;
}

}  // namespace

bool look_up(const tf2::BufferCore& buffer, const std::string& parent, const std::string& child, Stamp stamp,
             Pose& pose, std::string& why_not) {
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
  std::string reason;
  if (!buffer.canTransform(to, from, time, &reason)) {
    if (reason.empty()) reason = "tf does not know " + from + " in " + to;
    why_not = reason + "; publish it on tf or configure the pose";
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

void read_history(const tf2::BufferCore& buffer, const std::string& parent, const std::string& child,
                  Stamp after, Stamp until, std::vector<StampedPose>& poses) {
  const std::string to = ros_frame(parent);
  const std::string from = ros_frame(child);
  if (to.empty() || from.empty()) return;
  try {
    if (!buffer.canTransform(to, from, ros::Time(0))) return;
    const Stamp newest = from_ros(buffer.lookupTransform(to, from, ros::Time(0)).header.stamp);
    const Stamp last = std::min(newest, until);
    if (last >= after && last - after < shortest_step) return;
    // A track that is far ahead belongs to an input that has started again.
    Stamp at = after > last + longest_past ? last - longest_past : std::max(after, last - longest_past);
    for (at = at + sampling; at < last; at = at + sampling) sample(buffer, to, from, at, poses);
    if (last > after || at > after) sample(buffer, to, from, last, poses);
  } catch (const tf2::TransformException&) {
    // It was overwritten while it was read; the next call reads on.
  }
}

}  // namespace lidard
