// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "core/motion/pose_track.h"

namespace lidard {

/// The vehicle's way from its speed ahead and its turn rates, for the moment's motion only: it drifts without
/// bound, which does not matter over a sweep.
class DeadReckoning {
 public:
  /// Speed along x of base_frame, m/s. Not finite: counted, not used.
  void speed(double meters_per_s);
  /// Turn rates in base_frame, rad/s; adds a knot to `track`. Stamps that do not increase are counted and not
  /// used; a jump back or a gap of more than a second begins anew.
  void turn(Stamp stamp, const Eigen::Vector3d& rates, PoseTrack& track);

  std::uint64_t refused() const { return refused_; }

 private:
  Pose pose_ = Pose::Identity();
  double speed_ = 0;
  std::optional<Stamp> last_;
  Eigen::Vector3d last_rates_ = Eigen::Vector3d::Zero();
  std::uint64_t refused_ = 0;
};

}  // namespace lidard
