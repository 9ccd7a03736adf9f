// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/motion/frame_tree.h"
#include "core/motion/pose_track.h"
#include "daemon/pipeline/messages.h"

namespace lidard {

/// Stamps about 10 ms apart at which TransformSource::history() samples poses, of which the last one is of
/// `newest`; at most the last 2 s, which a merge may need.
std::vector<Stamp> history_stamps(Stamp newest, Stamp after, Stamp until);

/// The recorded motion of the vehicle, for a replay without a ROS master. Only poses stamped before the
/// requested time are used, as live.
class RecordedMotion : public TransformSource {
 public:
  bool lookup(const std::string& parent, const std::string& child, Stamp stamp, Pose& pose,
              std::string& why_not) final {
    return find(parent, child, stamp - shift_, pose, why_not);
  }
  void history(const std::string& parent, const std::string& child, Stamp after, Stamp until,
               std::vector<StampedPose>& poses) final;
  /// Passes the odometry's messages after the last call, up to `until`, to the pipeline. All poses are
  /// stamped later by `shift`, as a repeated capture is; the odometry begins anew where that changes.
  void feed(MessageReceiver& pipeline, Stamp until, Span shift = Span(0));
  /// All poses of base_frame, by stamp.
  virtual std::vector<StampedPose> track() = 0;

 protected:
  explicit RecordedMotion(const VehicleConfig& vehicle) : vehicle_(vehicle) {}
  void sort_odometry();
  /// As lookup() and history(), by the stamps of the record.
  virtual bool find(const std::string& parent, const std::string& child, Stamp stamp, Pose& pose,
                    std::string& why_not) = 0;
  virtual void sample(const std::string& parent, const std::string& child, Stamp after, Stamp until,
                      std::vector<StampedPose>& poses) = 0;

  const VehicleConfig vehicle_;
  std::vector<StampedPose> odometry_;
  std::string child_;  ///< whose poses they are

 private:
  std::size_t next_ = 0;
  Span shift_{0};
};

/// The motion from a table with rows of stamp (s since the epoch), x, y (m), yaw (rad): poses of base_frame
/// in odometry_frame, and messages of odometry_topic.
class MotionTable final : public RecordedMotion {
 public:
  /// An empty path: there is no table, and all poses are configured. Throws std::runtime_error that names the
  /// file.
  MotionTable(const std::string& path, const VehicleConfig& vehicle);
  std::vector<StampedPose> track() override { return odometry_; }

 private:
  void read(const std::string& path);
  bool find(const std::string& parent, const std::string& child, Stamp stamp, Pose& pose,
            std::string& why_not) override;
  void sample(const std::string& parent, const std::string& child, Stamp after, Stamp until,
              std::vector<StampedPose>& poses) override;

  PoseTrack track_;
};

}  // namespace lidard
