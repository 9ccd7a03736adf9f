// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/in/tf_poses.h"

#include <tf2/exceptions.h>
#include <tf2_ros/transform_listener.h>

#include <algorithm>
#include <stdexcept>

#include "daemon/health/sentences.h"
#include "daemon/log/log.h"
#include "daemon/ros/messages/bags_module.h"
#include "daemon/ros/messages/convert.h"

namespace lidard {
namespace {

/// Frames are looked up at most some hundred milliseconds after they were measured.
constexpr double live_kept_s = 10;

}  // namespace

ros::Time BufferPoses::time(Stamp stamp) const { return to_ros(clock_->host(stamp)); }

bool BufferPoses::lookup(const std::string& parent, const std::string& child, Stamp stamp, Pose& pose,
                         std::string& why_not) {
  const std::string to = ros_frame(parent);
  const std::string from = ros_frame(child);
  if (to.empty() || from.empty()) {
    why_not = text<says::tf_unnamed>();
    return false;
  }
  if (to == from) {
    pose = Pose::Identity();
    return true;
  }
  const ros::Time at = time(stamp);
  // Checked first: lookupTransform() throws, and unknown poses are common.
  std::string reason;
  if (!buffer_.canTransform(to, from, at, &reason)) {
    why_not = reason.empty() ? text<says::tf_unknown>(from, to) : text<says::tf_reason>(reason);
    return false;
  }
  try {
    pose = to_pose(buffer_.lookupTransform(to, from, at).transform);
  } catch (const tf2::TransformException& problem) {
    why_not = text<says::tf_reason>(problem.what());
    return false;
  }
  return true;
}

bool BufferPoses::is_before_step(const ros::Time& newest) {
  const std::lock_guard lock(mutex_);
  const HostStamp step = clock_->host(Stamp{});
  if (step_ && !(*step_ == step)) before_step_ = newest;
  step_ = step;
  return before_step_ == newest;
}

void BufferPoses::history(const std::string& parent, const std::string& child, Stamp after, Stamp until,
                          std::vector<StampedPose>& poses) {
  const std::string to = ros_frame(parent);
  const std::string from = ros_frame(child);
  if (to.empty() || from.empty()) return;
  try {
    if (!buffer_.canTransform(to, from, ros::Time(0))) return;
    const ros::Time header = buffer_.lookupTransform(to, from, ros::Time(0)).header.stamp;
    if (is_before_step(header)) return;
    for (const Stamp stamp : history_stamps(clock_->steady(from_ros(header)), after, until)) {
      const ros::Time at = time(stamp);
      if (buffer_.canTransform(to, from, at))
        poses.push_back({stamp, to_pose(buffer_.lookupTransform(to, from, at).transform)});
    }
  } catch (const tf2::TransformException&) {
    // It was overwritten while it was read; the next call reads on.
  }
}

TfPoses::TfPoses(SharedClockStep clock) : BufferPoses(live_kept_s, std::move(clock)) {}

bool TfPoses::lookup(const std::string& parent, const std::string& child, Stamp stamp, Pose& pose,
                     std::string& why_not) {
  if (BufferPoses::lookup(parent, child, stamp, pose, why_not)) return true;
  if (!listening_) why_not = text<says::tf_absent>();
  return false;
}

void TfPoses::connected(RosCallbackThread& ros) {
  constexpr bool own_thread = false;
  keep(std::make_shared<tf2_ros::TransformListener>(buffer_, ros.node(), own_thread));
  listening_ = true;
}

std::unique_ptr<RecordedMotion> open_motion(const std::string& path, const VehicleConfig& vehicle) {
  const bool is_table = path.size() > 4 && path.compare(path.size() - 4, 4, ".csv") == 0;
  if (path.empty() || is_table) return std::make_unique<MotionTable>(path, vehicle);
  return std::make_unique<BagPoses>(path, vehicle);
}

BagPoses::BagPoses(const std::string& path, const VehicleConfig& vehicle) : RecordedMotion(vehicle) {
  read(path);
  sort_odometry();
}

void BagPoses::read(const std::string& path) {
  bool any = false;
  const auto use_transforms = [&](const tf2_msgs::TFMessage& message, bool is_static) {
    any = true;
    for (const auto& transform : message.transforms) {
      buffer_.add(transform, is_static);
      if (!is_static && ros_frame(transform.header.frame_id) == ros_frame(vehicle_.odometry_frame))
        moved_.push_back(clock_->steady(from_ros(transform.header.stamp)));
    }
  };
  const auto use_odometry = [&](const nav_msgs::Odometry& message) {
    any = true;
    const auto& pose = message.pose.pose;
    odometry_.push_back(
        {clock_->steady(from_ros(message.header.stamp)), to_pose(pose.position, pose.orientation)});
    child_ = message.child_frame_id;
  };
  try {
    bags_function<decltype(lidard_read_poses)>("lidard_read_poses")(path, vehicle_.odometry_topic,
                                                                    use_transforms, use_odometry);
  } catch (const std::exception& problem) {
    if (any && dynamic_cast<const ros::Exception*>(&problem) != nullptr)
      return log_warn("{}: {}; the poses up to there are used", path, problem.what());
    throw std::runtime_error(path + ": " + problem.what() + "; expected a bag with /tf or the odometry");
  }
}

std::vector<StampedPose> BagPoses::track() {
  std::vector<StampedPose> poses;
  std::string why_not;
  Pose base = Pose::Identity(), pose;
  const bool is_base = child_.empty() || ros_frame(child_) == ros_frame(vehicle_.base_frame);
  for (const auto& [stamp, child] : odometry_) {
    if (is_base || lookup(child_, vehicle_.base_frame, stamp, base, why_not))
      poses.push_back({stamp, child * base});
  }
  if (!poses.empty() || vehicle_.odometry_frame.empty()) return poses;
  std::sort(moved_.begin(), moved_.end());
  moved_.erase(std::unique(moved_.begin(), moved_.end()), moved_.end());
  for (const Stamp stamp : moved_) {
    if (lookup(vehicle_.odometry_frame, vehicle_.base_frame, stamp, pose, why_not))
      poses.push_back({stamp, pose});
  }
  return poses;
}

}  // namespace lidard
