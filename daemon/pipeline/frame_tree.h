// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/pose.h"
#include "core/base/time.h"
#include "core/motion/pose_track.h"
#include "daemon/config/config.h"
#include "daemon/pipeline/sink.h"

namespace lidard {

/// Where something was at a time.
struct StampedPose {
  Stamp stamp;
  Pose pose;
};

/// Poses that the configuration does not hold (tf). Must answer at once.
class TransformSource {
 public:
  virtual ~TransformSource() = default;
  /// Pose of `child` in `parent` at `stamp`; false and a reason when it is not known.
  virtual bool lookup(const std::string& parent, const std::string& child, Stamp stamp, Pose& pose,
                      std::string& why_not) = 0;
  /// Appends the poses of `child` in `parent` after `after` (of a restart: whatever is known) and not after
  /// `until`, oldest first, in steps of about 10 ms.
  virtual void history(const std::string& parent, const std::string& child, Stamp after, Stamp until,
                       std::vector<StampedPose>& poses) {
    static_cast<void>(parent), static_cast<void>(child), static_cast<void>(after);
    static_cast<void>(until), static_cast<void>(poses);
  }
};

/// Without ROS there are no transforms but those of the configuration.
class NoTransforms final : public TransformSource {
 public:
  bool lookup(const std::string& parent, const std::string& child, Stamp, Pose&,
              std::string& why_not) override {
    why_not = "the pose of " + child + " in " + parent + " would come from tf, which needs ROS; configure it";
    return false;
  }
};

/// Where frames are: configured poses first, so that a vehicle without a tf tree works and replay is
/// deterministic; what the configuration does not hold comes from the lookup (tf).
class FrameTree {
 public:
  FrameTree(const Config& config, TransformSource& lookup);
  /// From now on the poses are those of another configuration.
  void configure(const Config& config);

  /// Pose of `child` in `parent` at `stamp`; false and the reason when it is not known.
  bool find(const std::string& parent, const std::string& child, Stamp stamp, Pose& pose,
            std::string& why_not) const;
  /// How the vehicle moves; nullptr: nobody tells.
  const PoseTrack* track() const { return track_; }
  void set_track(const PoseTrack* track) { track_ = track; }
  /// What the configuration holds, for /tf_static.
  const std::vector<StaticTransform>& transforms() const { return transforms_; }

 private:
  bool in_base(const std::string& frame, Stamp stamp, Pose& pose, std::string& why_not) const;

  std::string base_;
  const PoseTrack* track_ = nullptr;
  TransformSource& lookup_;
  std::map<std::string, std::pair<std::string, Pose>> known_;  // child: parent and pose in it
  std::vector<StaticTransform> transforms_;
};

}  // namespace lidard
