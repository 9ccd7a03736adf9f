// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/frames/cloud.h"
#include "core/motion/pose_track.h"

namespace lidard {

/// Brings the returns of a cloud to one instant: its end, but not later than the newest pose of the vehicle.
class CloudMotion {
 public:
  /// Finds how the cloud moves; false if the track does not cover it.
  bool find(const Cloud& cloud, const Pose& vehicle_from_cloud, const PoseTrack& track);

  Stamp instant() const { return instant_; }
  /// Nothing moved: returns stay where they are to the last bit.
  bool stands() const { return borders_.empty(); }
  /// From where the lidar was so long after the cloud's stamp to where it is at the instant. Outside of the
  /// cloud's time the motion of its begin or end.
  Pose at(double after_s) const;
  /// The motion of each column of the cloud; empty for a cloud without columns and while the vehicle stands.
  const std::vector<Pose>& columns() const { return columns_; }

 private:
  using Matrix = Eigen::Matrix<double, 3, 4>;

  bool find_borders(Stamp end, const Pose& vehicle_from_cloud, const PoseTrack& track);

  Stamp begin_{}, instant_{};
  double border_span_s_ = 0;
  // The motion at begin_ and every border_span_s_ from there to the cloud's end; empty: it stands. In between
  // it changes linearly: at 1.2 rad/s and 10 m this is 2 micrometres off.
  std::vector<Matrix> borders_;
  std::vector<Pose> columns_;
};

}  // namespace lidard
