// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <tf2/buffer_core.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "daemon/pipeline/pipeline.h"
#include "daemon/ros/in/component.h"

namespace lidard {

/// Poses from a buffer of tf2, direct or through a chain. The names may have a leading slash.
class BufferPoses : public TransformSource {
 public:
  /// `kept_s`: how long transforms are kept, s.
  BufferPoses(double kept_s, SharedClockStep clock)
      : buffer_(ros::Duration(kept_s)), clock_(std::move(clock)) {}
  bool lookup(const std::string& parent, const std::string& child, Stamp stamp, Pose& pose,
              std::string& why_not) override;
  void history(const std::string& parent, const std::string& child, Stamp after, Stamp until,
               std::vector<StampedPose>& poses) override;

 protected:
  ros::Time time(Stamp stamp) const;

  tf2::BufferCore buffer_;
  const SharedClockStep clock_;

 private:
  /// True if the buffer, whose newest transform is of `newest`, is older than the host clock's last step.
  bool is_before_step(const ros::Time& newest);

  std::mutex mutex_;               // for all below
  std::optional<HostStamp> step_;  // the host's time of Stamp(), which shows steps
  std::optional<ros::Time> before_step_;
};

/// Poses from tf. Listens while ROS runs; lookups never wait.
class TfPoses final : public BufferPoses, public RosComponent {
 public:
  explicit TfPoses(SharedClockStep clock = std::make_shared<ClockStep>());
  bool lookup(const std::string& parent, const std::string& child, Stamp stamp, Pose& pose,
              std::string& why_not) override;
  void connected(RosCallbackThread& ros) override;

 private:
  void disconnected() override { listening_ = false; }

  std::atomic<bool> listening_{false};
};

/// Poses from the /tf and /tf_static (and optional nav_msgs/Odometry) of a recorded bag, or from a table with
/// rows of stamp (s since the epoch), x, y (m), yaw (rad), for a replay without a ROS master. Only poses
/// stamped before the requested time are used, as live.
class BagPoses final : public BufferPoses {
 public:
  /// Reads a bag, or a file whose name ends with .csv. An empty path: there is none, and all poses are
  /// configured. Throws std::runtime_error that names the file; of a damaged bag, the first poses count.
  BagPoses(const std::string& path, const VehicleConfig& vehicle);
  bool lookup(const std::string& parent, const std::string& child, Stamp stamp, Pose& pose,
              std::string& why_not) override;
  void history(const std::string& parent, const std::string& child, Stamp after, Stamp until,
               std::vector<StampedPose>& poses) override;
  /// Passes the odometry's messages after the last call, up to `until`, to the pipeline. All poses are
  /// stamped later by `shift`, as a repeated capture is; the odometry begins anew where that changes.
  void feed(Pipeline& pipeline, Stamp until, Span shift = Span(0));
  /// All poses of base_frame, by stamp: of the odometry's topic, of odometry_frame on tf, or of the table.
  std::vector<StampedPose> track();

 private:
  void read_bag(const std::string& path);
  void read_table(const std::string& path);

  const VehicleConfig vehicle_;
  const bool is_there_;
  std::vector<StampedPose> odometry_;
  std::string child_;
  std::vector<Stamp> moved_;  // when tf moved something in odometry_frame
  std::size_t next_ = 0;
  Span shift_{0};
};

}  // namespace lidard
