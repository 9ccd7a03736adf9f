// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/pose.h"
#include "core/base/time.h"
#include "daemon/config/config.h"
#include "daemon/pipeline/sink.h"

namespace lidard {

/// A pose at a time.
struct StampedPose {
  Stamp stamp;
  Pose pose;
};

/// Source of poses that are not in the configuration (tf). Must not block.
class TransformSource {
 public:
  virtual ~TransformSource() = default;
  /// Pose of `child` in `parent` at `stamp`; false and a reason if it is unknown.
  virtual bool lookup(const std::string& parent, const std::string& child, Stamp stamp, Pose& pose,
                      std::string& why_not) = 0;
  /// Appends the poses of `child` in `parent` in (after, until], oldest first, in steps of about 10 ms; after
  /// a restart all known ones.
  virtual void history(const std::string& parent, const std::string& child, Stamp after, Stamp until,
                       std::vector<StampedPose>& poses) {
    static_cast<void>(parent), static_cast<void>(child), static_cast<void>(after);
    static_cast<void>(until), static_cast<void>(poses);
  }
};

/// The source without ROS: no transforms.
class NoTransforms final : public TransformSource {
 public:
  bool lookup(const std::string& parent, const std::string& child, Stamp, Pose&,
              std::string& why_not) override {
    why_not = "the pose of " + child + " in " + parent + " would come from tf, which needs ROS; configure it";
    return false;
  }
};

/// Poses of frames: configured poses first, so that a vehicle without a tf tree works and replay is
/// deterministic; then tf.
class FrameTree {
 public:
  FrameTree(const Config& config, TransformSource& lookup);
  /// Replaces the configured poses.
  void configure(const Config& config);

  /// Pose of `child` in `parent` at `stamp`; false and the reason if it is unknown.
  bool find(const std::string& parent, const std::string& child, Stamp stamp, Pose& pose,
            std::string& why_not) const;
  /// The configured transforms, for /tf_static.
  const std::vector<StaticTransform>& transforms() const { return transforms_; }

 private:
  bool in_base(const std::string& frame, Stamp stamp, Pose& pose, std::string& why_not) const;

  std::string base_;
  TransformSource& lookup_;
  std::map<std::string, std::pair<std::string, Pose>> known_;  // child: parent and pose in it
  std::vector<StaticTransform> transforms_;
};

}  // namespace lidard
