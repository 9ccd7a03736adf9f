// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "daemon/pipeline/sink.h"
#include "daemon/pipeline/transform_source.h"

namespace lidard {

class Pipeline;

/// Poses from the /tf and /tf_static (and, if asked for, nav_msgs/Odometry) of a recorded bag: what a replay
/// needs to deskew without a ROS master. Only what was stamped before the time that is asked about counts, as
/// it would live.
class BagPoses : public TransformSource {
 public:
  /// Reads the whole bag. An empty path: there is none, and all poses are configured. `odometry_topic` may be
  /// empty. Throws std::runtime_error that names the file.
  BagPoses(const std::string& path, const std::string& odometry_topic);
  ~BagPoses() override;

  bool lookup(const std::string& parent, const std::string& child, Stamp stamp, Pose& pose,
              std::string& why_not) override;
  void history(const std::string& parent, const std::string& child, Stamp after, Stamp until,
               std::vector<StampedPose>& poses) override;
  /// Gives the pipeline the odometry's messages after the last call, up to `until`.
  void feed(Pipeline& pipeline, Stamp until);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  std::vector<StampedPose> odometry_;
  std::string child_;
  std::size_t next_ = 0;
};

}  // namespace lidard
