// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/vehicle_motion.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

namespace lidard {
namespace {

constexpr double longest_lag_s = 0.5;
/// A speed of that age says little.
constexpr double longest_speed_s = 3;
constexpr double data_live_s = 1;

}  // namespace

VehicleMotion::VehicleMotion(const VehicleConfig& vehicle, TransformSource& transforms, FrameTree& frames)
    : vehicle_(vehicle), transforms_(transforms), frames_(frames) {
  configure();
}

void VehicleMotion::configure() { frames_.set_track(vehicle_.has_motion() ? &track_ : nullptr); }

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

std::optional<Pose> VehicleMotion::place(const std::string& parent, const std::string& child, Stamp stamp) {
  Pose pose = Pose::Identity();
  if (parent.empty() || child.empty() || frames_.find(parent, child, stamp, pose, why_refused_)) {
    why_refused_.clear();
    return pose;
  }
  ++refused_;
  return std::nullopt;
}

void VehicleMotion::add_pose(Stamp stamp, const Pose& pose, const std::string& child, Stamp now) {
  if (const auto child_from_base = place(child, vehicle_.base_frame, stamp))
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
  if (!speed_at_ || std::abs(seconds(now - *speed_at_)) > std::max(speed_lives_s_, longest_lag_s)) {
    ++without_speed_;
    why_refused_ = "no speed comes on " + vehicle_.speed_topic;
    return;
  }
  if (const auto base_from_imu = place(vehicle_.base_frame, frame, stamp))
    reckoning_.turn(stamp, base_from_imu->linear() * rates, track_);
  note_poses(now);
}

void VehicleMotion::note_poses(Stamp now) {
  if (track_.empty() || (pose_ && pose_->stamp == track_.newest())) return;
  pose_ = Newest{track_.newest(), now};
}

/// The fault, with the remedy; empty: none.
std::string VehicleMotion::trouble(Stamp now) const {
  if (track_.empty())
    return "no pose of the vehicle yet, so scans are not deskewed; see that odometry is published";
  const std::string& topic = vehicle_.odometry_topic.empty() ? vehicle_.imu_topic : vehicle_.odometry_topic;
  if (std::string clocks = topic_clock_.trouble("topic " + topic, false); !clocks.empty()) return clocks;
  const bool data_live = data_ && seconds(now - data_->arrival) < data_live_s;
  if (!data_live) {
    const bool pose_live = pose_ && seconds(now - pose_->arrival) < longest_lag_s;
    return pose_live ? "" : "no pose of the vehicle any more";
  }
  const double lag = seconds(data_->stamp - track_.newest());
  if (lag > longest_lag_s)
    return fmt::format(
        "the newest pose of the vehicle is {:.1f} s older than the newest scan, which is not deskewed; does "
        "odometry still come, and are its stamps of the same clock?",
        lag);
  const double ahead = seconds(track_.oldest() - data_->stamp);
  if (ahead > longest_lag_s)
    return fmt::format(
        "the oldest pose of the vehicle is {:.1f} s newer than the newest scan, which is not deskewed; are "
        "the stamps of both of the same clock?",
        ahead);
  return "";
}

std::optional<DiagnosticItem> VehicleMotion::diagnostics(Stamp now) const {
  if (!vehicle_.has_motion()) return std::nullopt;
  DiagnosticItem item{"motion"};
  const std::string what = trouble(now);
  item.set(what.empty() ? Health::ok : Health::warn, what.empty() ? "poses come in" : what);
  if (!what.empty() && !why_refused_.empty()) item.message += ": " + why_refused_;
  item.values = {{"Knots", std::to_string(track_.size())},
                 {"Jumps back", std::to_string(track_.restarts())},
                 {"Not rigid", std::to_string(track_.not_rigid())},
                 {"Frame not known", std::to_string(refused_)}};
  if (!vehicle_.speed_topic.empty()) item.add("Turn rates without speed", without_speed_);
  if (!track_.empty() && data_)
    item.add("Scans ahead of poses (s)", std::to_string(seconds(data_->stamp - track_.newest())));
  item.add("Stamps replaced", topic_clock_.replaced());
  item.add("Out of order", track_.out_of_order() + reckoning_.refused());
  return item;
}

}  // namespace lidard
