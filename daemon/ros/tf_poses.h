// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "daemon/pipeline/transform_source.h"
#include "daemon/ros/ros_component.h"

namespace tf2 {
class BufferCore;
}

namespace lidard {

/// Poses from tf, direct or through a chain. Listens while ROS runs; lookups never wait.
class TfPoses : public TransformSource, public RosComponent {
 public:
  TfPoses();

  bool lookup(const std::string& parent, const std::string& child, Stamp stamp, Pose& pose,
              std::string& why_not) override;
  void history(const std::string& parent, const std::string& child, Stamp after, Stamp until,
               std::vector<StampedPose>& poses) override;
  void connected(RosCallbackThread& ros) override;
  /// By how much the host's clock was set: tf is stamped with that clock, lookups ask for the time without
  /// steps. To be called by the thread that looks up.
  void set_step(Span step) { step_ = step; }
  void disconnected() override { listening_ = false; }

 private:
  std::shared_ptr<tf2::BufferCore> buffer_;
  Span step_{0};
  std::atomic<bool> listening_{false};
};

}  // namespace lidard
