// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/frames/cloud.h"
#include "core/frames/scan.h"
#include "core/motion/pose_track.h"

namespace lidard {

/// When the beams of a sweep were measured; they are counted in the order of measuring.
struct SweepTimes {
  Stamp first;
  double between = 0;  ///< s from beam to beam
  std::size_t beams = 0;

  Stamp at(std::size_t beam) const { return first + span_from_seconds(static_cast<double>(beam) * between); }
  Stamp last() const { return beams == 0 ? first : at(beams - 1); }
};

/// The times of a scan's beams; `scan.time_increment` must be one that `has_usable_times()`.
SweepTimes times_of(const PlanarScan& scan);
/// False if the time between beams is not finite, negative, or would make the sweep last longer than 10 s.
bool has_usable_times(const PlanarScan& scan);

/// The instant that all beams of a merge are brought to.
struct MergeMoment {
  Stamp at;
  const PoseTrack* track = nullptr;  ///< nullptr: nothing is known of motion, everything stands
  Pose output_from_base = Pose::Identity();
};

/// The vehicle's motion during a sweep: maps a beam's measurement from the output frame at the beam's time to
/// the output frame at the output's instant. Exact at borders about 1 ms apart; in between the transform
/// changes linearly (at 1.2 rad/s and 10 m this is 2 micrometres off).
class SweepMotion {
 public:
  using Matrix = Eigen::Matrix<double, 3, 4>;
  /// Beams [begin, end) with the transform of beam `begin`.
  struct Stretch {
    std::size_t begin, end;
    Matrix from;
    Matrix change;  ///< per beam
    void lead_to(const Stretch& next);
  };

  /// Computes the motion; `missing` if a pose is unknown: then everything stands.
  PoseOrigin follow(const MergeMoment& moment, const SweepTimes& times);
  /// Nothing moves.
  void stand() { stretches_.clear(); }

  bool stands() const { return stretches_.empty(); }
  const std::vector<Stretch>& stretches() const { return stretches_; }
  /// The transform of the first beam. Not while everything stands.
  Pose begin() const {
    Pose pose = Pose::Identity();
    pose.affine() = stretches_.front().from;
    return pose;
  }
  /// The measurement of `beam` at `point` (m), moved. Not while everything stands.
  Eigen::Vector3d moved(std::size_t beam, const Eigen::Vector3d& point) const {
    const Stretch& s = stretches_[std::min(beam / step_, stretches_.size() - 1)];
    return (s.from + static_cast<double>(beam - s.begin) * s.change) * point.homogeneous();
  }

 private:
  std::vector<Stretch> stretches_;
  std::size_t step_ = 1;  // beams per stretch
};

/// Brings the returns of a cloud to one instant.
class CloudMotion {
 public:
  /// Finds how the cloud moves; false if the track does not cover it. Unless `instant` is given, it is the
  /// cloud's end, but not later than the newest pose of the vehicle.
  bool find(const Cloud& cloud, const Pose& vehicle_from_cloud, const PoseTrack& track,
            std::optional<Stamp> instant = std::nullopt);

  Stamp instant() const { return instant_; }
  /// Nothing moved: returns stay where they are to the last bit.
  bool stands() const { return borders_.empty(); }
  /// The lidar's motion from `after_s` after the cloud's stamp to the instant. Outside of the cloud's time
  /// that of its begin or end.
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

/// A cloud with its lidar's pose on the vehicle.
struct PlacedCloud {
  const Cloud* cloud = nullptr;  ///< nullptr: there is none
  Pose vehicle_from_cloud = Pose::Identity();
  const CloudMotion* motion = nullptr;  ///< to the instant in question; nullptr: it stands
  bool is_sweep = false;                ///< of a planar scanner
};

/// Moves each return of a cloud to the lidar's pose at the instant of `motion`, and from there to another
/// frame. Its other fields stay, the time of measurement too.
void move_points(const CloudMotion& motion, const Pose& frame_from_lidar, Cloud& cloud);

}  // namespace lidard
