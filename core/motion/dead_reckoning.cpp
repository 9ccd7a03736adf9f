// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/motion/dead_reckoning.h"

#include <cmath>

namespace lidard {
namespace {

constexpr Span longest_step = std::chrono::seconds(1);

}  // namespace

void DeadReckoning::speed(double meters_per_s) {
  if (std::isfinite(meters_per_s))
    speed_ = meters_per_s;
  else
    ++refused_;
}

void DeadReckoning::turn(Stamp stamp, const Eigen::Vector3d& rates, PoseTrack& track) {
  if (!rates.allFinite()) {
    ++refused_;
    return;
  }
  const bool anew = !last_ || stamp - *last_ > longest_step || *last_ - stamp > longest_step;
  if (!anew && stamp <= *last_) {
    ++refused_;
    return;
  }
  if (!anew) {
    const double dt = seconds(stamp - *last_);
    const Eigen::Vector3d turned = (rates + last_rates_) / 2 * dt;
    const double angle = turned.norm();
    const Eigen::AngleAxisd half(angle / 2,
                                 angle > 0 ? Eigen::Vector3d(turned / angle) : Eigen::Vector3d::UnitZ());
    // On a circle the chord has the heading of its middle.
    pose_ = pose_ * half * Eigen::Translation3d(speed_ * dt, 0, 0) * half;
    pose_.linear() = Eigen::Quaterniond(pose_.linear()).normalized().toRotationMatrix();
  }
  last_ = stamp;
  last_rates_ = rates;
  track.add(stamp, pose_);
}

}  // namespace lidard
