// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/offline/recorded_motion.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <stdexcept>

#include "daemon/offline/no_transforms.h"

namespace lidard {

std::vector<Stamp> history_stamps(Stamp newest, Stamp after, Stamp until) {
  // The vehicle's path between samples is straight; tf itself interpolates linearly.
  constexpr Span sampling = std::chrono::milliseconds(10);
  constexpr Span shortest_step = std::chrono::milliseconds(5);
  constexpr Span longest_past = std::chrono::seconds(2);
  std::vector<Stamp> stamps;
  const Stamp last = std::min(newest, until);
  if (last >= after && last - after < shortest_step) return stamps;
  // A track that is far ahead belongs to an input that has started again.
  Stamp at = after > last + longest_past ? last - longest_past : std::max(after, last - longest_past);
  for (at = at + sampling; at < last; at = at + sampling) stamps.push_back(at);
  if (last > after || at > after) stamps.push_back(last);
  return stamps;
}

void RecordedMotion::sort_odometry() {
  std::stable_sort(odometry_.begin(), odometry_.end(),
                   [](const StampedPose& a, const StampedPose& b) { return a.stamp < b.stamp; });
}

void RecordedMotion::history(const std::string& parent, const std::string& child, Stamp after, Stamp until,
                             std::vector<StampedPose>& poses) {
  const std::size_t before = poses.size();
  sample(parent, child, after - shift_, until - shift_, poses);
  for (std::size_t i = before; i < poses.size(); ++i) poses[i].stamp = poses[i].stamp + shift_;
}

void RecordedMotion::feed(MessageReceiver& pipeline, Stamp until, Span shift) {
  if (shift_ != shift) next_ = 0;
  shift_ = shift;
  if (vehicle_.odometry_topic.empty()) return;
  for (; next_ < odometry_.size() && odometry_[next_].stamp + shift <= until; ++next_) {
    const auto& [stamp, pose] = odometry_[next_];
    pipeline.pose_message(stamp + shift, pose, child_, stamp + shift);
  }
}

MotionTable::MotionTable(const std::string& path, const VehicleConfig& vehicle) : RecordedMotion(vehicle) {
  if (path.empty()) return;
  child_ = vehicle_.base_frame;
  read(path);
  sort_odometry();
  track_ = PoseTrack({odometry_.size(), Span::max(), Span(0)});
  for (const auto& [stamp, pose] : odometry_) track_.add(stamp, pose);
}

void MotionTable::read(const std::string& path) {
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
}

bool MotionTable::find(const std::string& parent, const std::string& child, Stamp stamp, Pose& pose,
                       std::string& why_not) {
  if (parent == child) {
    pose = Pose::Identity();
    return true;
  }
  const bool is_back = parent == vehicle_.base_frame && child == vehicle_.odometry_frame;
  const bool is_known = is_back || (parent == vehicle_.odometry_frame && child == vehicle_.base_frame);
  if (!is_known || track_.empty()) return NoTransforms().lookup(parent, child, stamp, pose, why_not);
  if (track_.at(stamp, pose) != PoseOrigin::known) {
    why_not = "the table of the motion has no pose of that time";
    return false;
  }
  if (is_back) pose = pose.inverse();
  return true;
}

void MotionTable::sample(const std::string& parent, const std::string& child, Stamp after, Stamp until,
                         std::vector<StampedPose>& poses) {
  if (track_.empty() || parent != vehicle_.odometry_frame || child != vehicle_.base_frame) return;
  Pose pose;
  for (const Stamp at : history_stamps(track_.newest(), after, until)) {
    if (track_.at(at, pose) == PoseOrigin::known) poses.push_back({at, pose});
  }
}

}  // namespace lidard
