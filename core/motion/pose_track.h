// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/pose.h"
#include "core/base/time.h"

namespace lidard {

/// Origin of a track's pose: knots on both sides of its time, the last motion carried on, or nothing.
enum class PoseOrigin : std::uint8_t { known, extrapolated, missing };

struct PoseTrackSettings {
  std::size_t knots = 1024;                                ///< memory; 10 s of 100 Hz
  Span max_pose_gap = std::chrono::milliseconds(250);      ///< between knots; across more nothing is known
  Span max_extrapolation = std::chrono::milliseconds(50);  ///< beyond the newest knot
};

/// Where the vehicle was: the newest poses of its base in a frame that does not move with it (odometry), and
/// between them translation in a straight line and rotation at a steady rate. Fixed memory.
class PoseTrack {
 public:
  explicit PoseTrack(const PoseTrackSettings& settings = {});

  /// Adds a knot. False if it is rejected: not newer than the newest one, or not a rigid transform. A stamp
  /// more than 1 s back restarts the track: a clock was set, or an input starts again.
  bool add(Stamp stamp, const Pose& odom_from_base);
  /// The pose at a time. Beyond the newest knot the last motion, and its change, are carried on for a short
  /// while. Leaves `pose` alone if it is missing.
  PoseOrigin at(Stamp stamp, Pose& pose) const;
  /// True if no moment from `first` to `last` lacks its pose.
  bool covers(Stamp first, Stamp last) const;
  void clear() { count_ = 0; }

  bool empty() const { return count_ == 0; }
  std::size_t size() const { return count_; }
  /// Stamps of the outermost knots; of an empty track 0.
  Stamp oldest() const { return empty() ? Stamp{} : knot(0).stamp; }
  Stamp newest() const { return empty() ? Stamp{} : knot(count_ - 1).stamp; }
  const PoseTrackSettings& settings() const { return settings_; }

  /// Knots with a stamp that is not newer than the newest one's.
  std::uint64_t out_of_order() const { return out_of_order_; }
  /// Restarts of the track, since stamps jumped back.
  std::uint64_t restarts() const { return restarts_; }
  /// Poses with numbers that are not finite, or without a valid rotation.
  std::uint64_t not_rigid() const { return not_rigid_; }

 private:
  struct Knot {
    Stamp stamp;
    Eigen::Vector3d position;
    Eigen::Quaterniond turn;
  };
  const Knot& knot(std::size_t i) const { return ring_[(first_ + i) % ring_.size()]; }
  static bool same_pose(const Knot& a, const Knot& b);
  /// The number of knots not later than `stamp`.
  std::size_t knots_until(Stamp stamp) const;
  struct Twist {
    Eigen::Vector3d turn = Eigen::Vector3d::Zero();  // rad/s
    Eigen::Vector3d way = Eigen::Vector3d::Zero();   // m/s
  };
  static Twist twist(const Knot& from, const Knot& to);
  /// The knot from which the way to knot `end` is long enough for a twist; `end` if there is none.
  std::size_t twist_begin(std::size_t end) const;
  PoseOrigin beyond(Stamp stamp, Pose& pose) const;

  PoseTrackSettings settings_;
  std::vector<Knot> ring_;
  std::size_t first_ = 0;
  std::size_t count_ = 0;
  std::uint64_t out_of_order_ = 0;
  std::uint64_t restarts_ = 0;
  std::uint64_t not_rigid_ = 0;
};

/// Integrates the vehicle's forward speed and turn rates. The result drifts without bound, which does not
/// matter over a sweep.
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
