// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <tf2/buffer_core.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "daemon/offline/recorded_motion.h"
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
  void add(const geometry_msgs::TransformStamped& transform, bool is_static) {
    buffer_.setTransform(transform, "bag", is_static);
  }

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

/// Poses from the /tf and /tf_static (and optional nav_msgs/Odometry) of a recorded bag.
class BagPoses final : public RecordedMotion {
 public:
  /// Throws std::runtime_error that names the file; of a damaged bag, the first poses count.
  BagPoses(const std::string& path, const VehicleConfig& vehicle);
  /// Of the odometry's topic, or of odometry_frame on tf.
  std::vector<StampedPose> track() override;

 private:
  // A bag is kept completely.
  static constexpr double bag_kept_s = 1e7;

  void read(const std::string& path);
  bool find(const std::string& parent, const std::string& child, Stamp stamp, Pose& pose,
            std::string& why_not) override {
    return buffer_.lookup(parent, child, stamp, pose, why_not);
  }
  void sample(const std::string& parent, const std::string& child, Stamp after, Stamp until,
              std::vector<StampedPose>& poses) override {
    buffer_.history(parent, child, after, until, poses);
  }

  const SharedClockStep clock_ = std::make_shared<ClockStep>();
  BufferPoses buffer_{bag_kept_s, clock_};
  std::vector<Stamp> moved_;  // when tf moved something in odometry_frame
};

/// The motion of a bag, or of a table whose name ends with .csv; an empty path: none, all poses are
/// configured. Throws std::runtime_error that names the file.
std::unique_ptr<RecordedMotion> open_motion(const std::string& path, const VehicleConfig& vehicle);

}  // namespace lidard
