// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/vehicle_motion.h"

#include <algorithm>
#include <cmath>

namespace lidard {
namespace {

/// A speed of that age says little.
constexpr double longest_speed_s = 3;
constexpr double data_live_s = 1;

}  // namespace

void VehicleMotion::poll(Stamp now) {
  // Packets are much more frequent than poses.
  constexpr Span between_polls = std::chrono::milliseconds(5);
  if (vehicle_.odometry_frame.empty()) return;
  if (now >= last_poll_ && now - last_poll_ < between_polls) return;
  last_poll_ = now;
  new_poses_.clear();
  transforms_.history(vehicle_.odometry_frame, vehicle_.base_frame, track_.newest(), now, new_poses_);
  for (const StampedPose& one : new_poses_) track_.add(one.stamp, one.pose);
  note_poses(now);
}

std::optional<Pose> VehicleMotion::find_pose(const std::string& parent, const std::string& child,
                                             Stamp stamp) {
  Pose pose = Pose::Identity();
  if (parent.empty() || child.empty() || frames_.find(parent, child, stamp, pose, counted_.why_refused)) {
    counted_.why_refused.clear();
    return pose;
  }
  ++counted_.refused;
  return std::nullopt;
}

void VehicleMotion::add_pose(Stamp stamp, const Pose& pose, const std::string& child, Stamp now) {
  if (const auto child_from_base = find_pose(child, vehicle_.base_frame, stamp))
    track_.add(stamp, pose * *child_from_base);
  note_poses(now);
}

void VehicleMotion::add_speed(double speed, Stamp now) {
  reckoning_.speed(speed);
  if (!std::isfinite(speed)) return;
  if (speed_at_) speed_lives_s_ = std::min(3 * seconds(now - *speed_at_), longest_speed_s);
  speed_at_ = now;
}

void VehicleMotion::add_turn(Stamp stamp, const Eigen::Vector3d& rates, const std::string& frame, Stamp now) {
  counted_.lacks_speed =
      !speed_at_ || std::abs(seconds(now - *speed_at_)) > std::max(speed_lives_s_, longest_lag_s);
  if (counted_.lacks_speed) {
    ++counted_.without_speed;
    return;
  }
  if (const auto base_from_imu = find_pose(vehicle_.base_frame, frame, stamp))
    reckoning_.turn(stamp, base_from_imu->linear() * rates, track_);
  note_poses(now);
}

void VehicleMotion::note_poses(Stamp now) {
  if (track_.empty() || (pose_ && pose_->stamp == track_.newest())) return;
  pose_ = Newest{track_.newest(), now};
}

std::optional<MotionStatus> VehicleMotion::status(Stamp now) const {
  if (!vehicle_.has_motion()) return std::nullopt;
  MotionStatus status = counted_;
  status.has_poses = !track_.empty();
  status.topic = vehicle_.odometry_topic.empty() ? vehicle_.imu_topic : vehicle_.odometry_topic;
  status.speed_topic = vehicle_.speed_topic;
  status.clock_ahead = topic_clock_.ahead();
  status.data_live = data_ && seconds(now - data_->arrival) < data_live_s;
  status.poses_live = pose_ && seconds(now - pose_->arrival) < longest_lag_s;
  if (data_ && status.has_poses) {
    status.data_ahead_s = seconds(data_->stamp - track_.newest());
    status.poses_ahead_s = seconds(track_.oldest() - data_->stamp);
  }
  status.knots = track_.size();
  status.jumps_back = track_.restarts();
  status.not_rigid = track_.not_rigid();
  status.stamps_replaced = topic_clock_.replaced();
  status.out_of_order = track_.out_of_order() + reckoning_.refused();
  return status;
}

}  // namespace lidard
