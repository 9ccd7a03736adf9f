// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/base/pose.h"
#include "core/base/time.h"

namespace lidard {

/// A fixed transform.
struct StaticTransform {
  std::string parent;
  std::string child;
  Pose pose;  ///< of child in parent
};

/// A pose at a time.
struct StampedPose {
  Stamp stamp;
  Pose pose;
};

/// Source of poses that are not fixed (tf). Must not block.
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

/// Poses of frames: fixed ones first, so that a vehicle without a tf tree works and replay is deterministic;
/// then tf.
class FrameTree {
 public:
  /// `lookup` must outlive this.
  FrameTree(std::string base, std::vector<StaticTransform> fixed, TransformSource& lookup) : lookup_(lookup) {
    configure(std::move(base), std::move(fixed));
  }
  /// Replaces the frame of the vehicle and the fixed poses; the first one of a frame counts.
  void configure(std::string base, std::vector<StaticTransform> fixed);

  /// Pose of `child` in `parent` at `stamp`; false and the reason if it is unknown.
  bool find(const std::string& parent, const std::string& child, Stamp stamp, Pose& pose,
            std::string& why_not) const;
  /// The fixed poses, for /tf_static.
  const std::vector<StaticTransform>& fixed() const { return fixed_; }

 private:
  bool in_base(const std::string& frame, Stamp stamp, Pose& pose, std::string& why_not) const;

  std::string base_;
  TransformSource& lookup_;
  std::map<std::string, std::pair<std::string, Pose>> known_;  // child: parent and pose in it
  std::vector<StaticTransform> fixed_;
};

}  // namespace lidard
