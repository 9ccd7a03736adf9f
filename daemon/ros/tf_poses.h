// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "daemon/pipeline/transform_source.h"
#include "daemon/ros/ros_link.h"

namespace lidard {

/// Poses from tf, direct or through a chain. Listens while ROS runs; lookups never wait.
class TfPoses : public TransformSource, public RosClient {
 public:
  TfPoses();
  ~TfPoses() override;

  bool lookup(const std::string& parent, const std::string& child, Stamp stamp, Pose& pose,
              std::string& why_not) override;
  void history(const std::string& parent, const std::string& child, Stamp after, Stamp until,
               std::vector<StampedPose>& poses) override;
  void connected() override;
  void disconnected(bool leave) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lidard
