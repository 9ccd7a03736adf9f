// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/cloud.h"
#include "core/pose_track.h"

namespace lidard {

/// Brings the returns of a cloud to one instant: its end, but not later than the newest pose of the vehicle.
class CloudMotion {
 public:
  /// Finds how each column moves; false if the track does not cover the cloud.
  bool find(const Cloud& cloud, const Pose& vehicle_from_cloud, const PoseTrack& track);

  Stamp instant() const { return instant_; }
  /// By column of the cloud: from where the lidar was to where it is at the instant. Empty for a cloud
  /// without columns.
  const std::vector<Pose>& columns() const { return columns_; }
  /// The cloud itself if it has columns, else a copy with its points moved by their own times.
  const Cloud& moved(const Cloud& cloud);

 private:
  const Pose& at(Stamp stamp);

  const PoseTrack* track_ = nullptr;
  Pose vehicle_from_cloud_ = Pose::Identity();
  Pose now_from_odom_ = Pose::Identity();  // in the cloud's frame
  Stamp instant_{};
  Stamp newest_at_{};
  Pose newest_ = Pose::Identity();
  std::vector<Pose> columns_;
  Cloud copy_;
};

}  // namespace lidard
