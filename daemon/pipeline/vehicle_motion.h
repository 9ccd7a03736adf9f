// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/topic_clock.h"
#include "core/motion/frame_tree.h"
#include "core/motion/pose_track.h"
#include "daemon/config/config.h"
#include "daemon/pipeline/status.h"

namespace lidard {

/// The vehicle's motion: collects poses from tf, from odometry, or from turn rates and speed, and checks that
/// they keep up with the sensors' data. Stamps are compared only with stamps, since arrivals use another
/// clock in simulation and replay.
class VehicleMotion {
 public:
  /// The arguments must outlive this.
  VehicleMotion(const VehicleConfig& vehicle, TransformSource& transforms, const FrameTree& frames)
      : vehicle_(vehicle), transforms_(transforms), frames_(frames) {}

  /// The poses of the vehicle; nullptr: there is no source of motion.
  const PoseTrack* track() const { return vehicle_.has_motion() ? &track_ : nullptr; }

  /// The stamp of a message, or what replaces it; `arrival`: by the clock that stamps messages.
  Stamp stamp_of(Stamp stamp, Stamp arrival) { return topic_clock_.correct(stamp, Span(0), arrival); }
  /// Adds new poses from tf.
  void poll(Stamp now);
  /// Adds a pose of `child` (empty: base_frame) in the odometry's frame.
  void add_pose(Stamp stamp, const Pose& pose, const std::string& child, Stamp now);
  /// Adds turn rates in `frame` (empty: base_frame), rad/s; without a recent speed they are no pose.
  void add_turn(Stamp stamp, const Eigen::Vector3d& rates, const std::string& frame, Stamp now);
  /// Sets the speed, m/s along x of base_frame.
  void add_speed(double speed, Stamp now);
  /// Reports data of a sensor measured at `stamp`.
  void note_data(Stamp stamp, Stamp now) { data_ = Newest{stamp, now}; }
  /// The input starts again.
  void restart() {
    track_.clear();
    speed_at_.reset();
    counted_.why_refused.clear();
    counted_.lacks_speed = false;
  }
  /// None: there is no source of motion.
  std::optional<MotionStatus> status(Stamp now) const;

 private:
  struct Newest {
    Stamp stamp;
    Stamp arrival;
  };
  /// The pose of a frame on the vehicle; counts failures.
  std::optional<Pose> find_pose(const std::string& parent, const std::string& child, Stamp stamp);
  void note_poses(Stamp now);

  const VehicleConfig& vehicle_;
  TransformSource& transforms_;
  const FrameTree& frames_;
  TopicClock topic_clock_{std::chrono::seconds(1)};  // poses may be predicted
  PoseTrack track_;
  DeadReckoning reckoning_;
  std::vector<StampedPose> new_poses_;
  Stamp last_poll_{};
  std::optional<Stamp> speed_at_;  // arrival of the newest speed
  double speed_lives_s_ = 0;       // three periods of it
  std::optional<Newest> data_, pose_;
  MotionStatus counted_;  // what status() need not ask others
};

}  // namespace lidard
