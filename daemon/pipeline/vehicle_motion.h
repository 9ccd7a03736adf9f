// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/motion/pose_track.h"
#include "daemon/config/config.h"
#include "daemon/pipeline/frame_tree.h"
#include "daemon/pipeline/sink.h"

namespace lidard {

/// How the vehicle moves: collects its poses from tf, from odometry, or from turn rates and speed, and
/// watches that they keep up with the sensors' data. Stamps are compared with stamps alone, since under
/// simulated time, or in a replay, they are of another clock than arrivals.
class VehicleMotion {
 public:
  /// All must outlive this; `frames` gets the track.
  VehicleMotion(const VehicleConfig& vehicle, TransformSource& transforms, FrameTree& frames);
  /// `vehicle` or the frames are others now.
  void configure();

  /// Takes what tf has learned of the vehicle's way.
  void poll(Stamp now);
  /// A pose of `child` (empty: base_frame) in the odometry's frame.
  void add_pose(Stamp stamp, const Pose& pose, const std::string& child, Stamp now);
  /// Turn rates in `frame` (empty: base_frame), rad/s.
  void add_turn(Stamp stamp, const Eigen::Vector3d& rates, const std::string& frame, Stamp now);
  /// m/s along x of base_frame.
  void add_speed(double speed) { reckoning_.speed(speed); }
  /// Data of a sensor came in that was measured at `stamp`.
  void note_data(Stamp stamp, Stamp now) { data_ = Newest{stamp, now}; }
  /// The input starts again.
  void restart() { track_.clear(); }
  const FrameTree& frames() const { return frames_; }
  const std::string& base_frame() const { return vehicle_.base_frame; }
  /// Whether poses come as they should; none: nobody tells how the vehicle moves.
  std::optional<DiagnosticItem> diagnostics(Stamp now) const;

 private:
  struct Newest {
    Stamp stamp;
    Stamp arrival;
  };
  /// Where a frame is on the vehicle; counts those that are not known.
  std::optional<Pose> place(const std::string& parent, const std::string& child, Stamp stamp);
  void note_poses(Stamp now);
  std::string trouble(Stamp now) const;

  const VehicleConfig& vehicle_;
  TransformSource& transforms_;
  FrameTree& frames_;
  PoseTrack track_;
  DeadReckoning reckoning_;
  std::vector<StampedPose> new_poses_;
  Stamp last_poll_{};
  std::optional<Newest> data_, pose_;
  std::uint64_t refused_ = 0;  // poses whose frame's place on the vehicle is not known
  std::string why_refused_;
};

}  // namespace lidard
