// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/in/tf_poses.h"

#include <fmt/format.h>
#include <geometry_msgs/TransformStamped.h>
#include <tf2/exceptions.h>
#include <tf2_ros/transform_listener.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <stdexcept>

#include "daemon/pipeline/log.h"
#include "daemon/ros/messages/bags_module.h"
#include "daemon/ros/messages/convert.h"

namespace lidard {
namespace {

// The vehicle's path between such samples of tf is straight; tf itself interpolates linearly.
constexpr Span sampling = std::chrono::milliseconds(10);
constexpr Span shortest_step = std::chrono::milliseconds(5);
// The oldest poses that a merge may need.
constexpr Span longest_past = std::chrono::seconds(2);
/// Frames are looked up at most some hundred milliseconds after they were measured.
constexpr double live_kept_s = 10;
// A bag is kept completely.
constexpr double bag_kept_s = 1e7;

}  // namespace

ros::Time BufferPoses::time(Stamp stamp) const { return to_ros(clock_->host(stamp)); }

bool BufferPoses::lookup(const std::string& parent, const std::string& child, Stamp stamp, Pose& pose,
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
  const ros::Time at = time(stamp);
  // Checked first: lookupTransform() throws, and unknown poses are common.
  std::string reason;
  if (!buffer_.canTransform(to, from, at, &reason)) {
    if (reason.empty()) reason = "tf does not know " + from + " in " + to;
    why_not = reason + "; publish it on tf or configure the pose";
    return false;
  }
  try {
    pose = to_pose(buffer_.lookupTransform(to, from, at).transform);
  } catch (const tf2::TransformException& problem) {
    why_not = problem.what();
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
  const auto sample = [&](Stamp stamp) {
    const ros::Time at = time(stamp);
    if (buffer_.canTransform(to, from, at))
      poses.push_back({stamp, to_pose(buffer_.lookupTransform(to, from, at).transform)});
  };
  try {
    if (!buffer_.canTransform(to, from, ros::Time(0))) return;
    const ros::Time header = buffer_.lookupTransform(to, from, ros::Time(0)).header.stamp;
    if (is_before_step(header)) return;
    const Stamp newest = clock_->steady(from_ros(header));
    const Stamp last = std::min(newest, until);
    if (last >= after && last - after < shortest_step) return;
    // A track that is far ahead belongs to an input that has started again.
    Stamp at = after > last + longest_past ? last - longest_past : std::max(after, last - longest_past);
    for (at = at + sampling; at < last; at = at + sampling) sample(at);
    if (last > after || at > after) sample(last);
  } catch (const tf2::TransformException&) {
    // It was overwritten while it was read; the next call reads on.
  }
}

TfPoses::TfPoses(SharedClockStep clock) : BufferPoses(live_kept_s, std::move(clock)) {}

bool TfPoses::lookup(const std::string& parent, const std::string& child, Stamp stamp, Pose& pose,
                     std::string& why_not) {
  if (BufferPoses::lookup(parent, child, stamp, pose, why_not)) return true;
  if (!listening_) why_not = "no tf: there was no ROS master yet; publish it on tf or configure the pose";
  return false;
}

void TfPoses::connected(RosCallbackThread& ros) {
  constexpr bool own_thread = false;
  keep(std::make_shared<tf2_ros::TransformListener>(buffer_, ros.node(), own_thread));
  listening_ = true;
}

BagPoses::BagPoses(const std::string& path, const VehicleConfig& vehicle)
    : BufferPoses(bag_kept_s, std::make_shared<ClockStep>()), vehicle_(vehicle), is_there_(!path.empty()) {
  if (!is_there_) return;
  if (path.size() > 4 && path.compare(path.size() - 4, 4, ".csv") == 0)
    read_table(path);
  else
    read_bag(path);
  std::stable_sort(odometry_.begin(), odometry_.end(),
                   [](const StampedPose& a, const StampedPose& b) { return a.stamp < b.stamp; });
}

void BagPoses::read_bag(const std::string& path) {
  bool any = false;
  const auto use_transforms = [&](const tf2_msgs::TFMessage& message, bool is_static) {
    any = true;
    for (const auto& transform : message.transforms) {
      buffer_.setTransform(transform, "bag", is_static);
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

void BagPoses::read_table(const std::string& path) {
  errno = 0;
  std::ifstream file(path);
  if (!file) throw std::runtime_error(path + ": cannot be opened: " + std::strerror(errno));
  std::string line;
  for (std::size_t number = 1; std::getline(file, line); ++number) {
    double stamp = 0, x = 0, y = 0, yaw = 0;
    const bool read = std::sscanf(line.c_str(), "%lf , %lf , %lf , %lf", &stamp, &x, &y, &yaw) == 4 &&
                      std::isfinite(stamp + x + y + yaw);
    const bool title = number == 1 && !read;
    if (!read && !title)
      throw std::runtime_error(
          fmt::format("{}:{}: '{}'; expected stamp,x,y,yaw: s, m, m, rad", path, number, line));
    if (read) odometry_.push_back({Stamp{} + span_from_seconds(stamp), make_pose({x, y, 0}, {0, 0, yaw})});
  }
  if (odometry_.empty()) throw std::runtime_error(path + ": no poses; expected rows of stamp,x,y,yaw");
  child_ = vehicle_.base_frame;
  if (vehicle_.odometry_frame.empty()) return;
  for (const auto& [at, pose] : odometry_) {
    geometry_msgs::TransformStamped moved;
    moved.header.stamp = time(at), moved.header.frame_id = ros_frame(vehicle_.odometry_frame);
    moved.child_frame_id = ros_frame(vehicle_.base_frame);
    const Eigen::Quaterniond turn(pose.linear());
    moved.transform.translation.x = pose.translation().x(),
    moved.transform.translation.y = pose.translation().y();
    moved.transform.rotation.z = turn.z(), moved.transform.rotation.w = turn.w();
    buffer_.setTransform(moved, "table", false);
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

bool BagPoses::lookup(const std::string& parent, const std::string& child, Stamp stamp, Pose& pose,
                      std::string& why_not) {
  return is_there_ ? BufferPoses::lookup(parent, child, stamp - shift_, pose, why_not)
                   : NoTransforms().lookup(parent, child, stamp, pose, why_not);
}

void BagPoses::history(const std::string& parent, const std::string& child, Stamp after, Stamp until,
                       std::vector<StampedPose>& poses) {
  const std::size_t before = poses.size();
  BufferPoses::history(parent, child, after - shift_, until - shift_, poses);
  for (std::size_t i = before; i < poses.size(); ++i) poses[i].stamp = poses[i].stamp + shift_;
}

void BagPoses::feed(Pipeline& pipeline, Stamp until, Span shift) {
  if (shift_ != shift) next_ = 0;
  shift_ = shift;
  if (vehicle_.odometry_topic.empty()) return;
  for (; next_ < odometry_.size() && odometry_[next_].stamp + shift <= until; ++next_) {
    const auto& [stamp, pose] = odometry_[next_];
    pipeline.pose_message(stamp + shift, pose, child_, stamp + shift);
  }
}

}  // namespace lidard
