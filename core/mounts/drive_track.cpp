// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/mounts/drive_track.h"

#include <algorithm>
#include <cmath>

#include "core/base/angle.h"

namespace lidard {
namespace {

constexpr double way_of_turn = 0.5;  // m per rad

}  // namespace

DriveTrack::DriveTrack(std::vector<OdometryPose> poses, double scale, double turn_scale)
    : poses_(std::move(poses)) {
  ways_.push_back(0);
  PlanarPose before = poses_.front().pose;
  for (std::size_t i = 1; i < poses_.size(); ++i) {
    PlanarPose step = before.inverse() * poses_[i].pose;
    before = poses_[i].pose;
    step = {scale * step.x, scale * step.y, turn_scale * step.yaw};
    poses_[i].pose = poses_[i - 1].pose * step;
    ways_.push_back(ways_.back() + std::hypot(step.x, step.y) + way_of_turn * std::abs(step.yaw));
  }
}

std::size_t DriveTrack::after(double time) const {
  const auto next = std::lower_bound(poses_.begin(), poses_.end(), time,
                                     [](const OdometryPose& pose, double at) { return pose.time < at; });
  return static_cast<std::size_t>(std::clamp(next, poses_.begin() + 1, poses_.end() - 1) - poses_.begin());
}

PlanarPose DriveTrack::at(double time) const {
  const std::size_t next = after(time);
  const OdometryPose &a = poses_[next - 1], &b = poses_[next];
  const double share = (time - a.time) / std::max(1e-9, b.time - a.time);
  return {a.pose.x + share * (b.pose.x - a.pose.x), a.pose.y + share * (b.pose.y - a.pose.y),
          a.pose.yaw + share * std::remainder(b.pose.yaw - a.pose.yaw, two_pi)};
}

double DriveTrack::way(double time) const {
  const std::size_t next = after(time);
  const double length = std::max(1e-9, poses_[next].time - poses_[next - 1].time);
  return ways_[next - 1] + (time - poses_[next - 1].time) / length * (ways_[next] - ways_[next - 1]);
}

}  // namespace lidard
