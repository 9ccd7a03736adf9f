// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "daemon/config/config.h"
#include "daemon/pipeline/frame_tree.h"
#include "daemon/ros/ros_component.h"
#include "daemon/ros/ros_connection.h"
#include "daemon/ros/tf_poses.h"

namespace lidard {

class Pipeline;

/// All that a pipeline has to do with ROS: a sink for what it produces, poses from tf, and, once feed() is
/// called, what other nodes publish for it and change of it. The same live, in replay and in the drop-ins.
class RosSession : public RosConnection {
 public:
  /// Throws RosError.
  RosSession(const Config& config, const RosOptions& options);

  /// tf; must not be used after the session ended.
  TransformSource& poses() { return *poses_; }
  /// Lets messages of `topic:` and `packet_topic:` sensors, of the vehicle's motion and of
  /// dynamic_reconfigure reach the pipeline, which must outlive the session's use. To be called before
  /// start().
  void feed(Pipeline& pipeline, const RosPost& post);

 private:
  const Config& config_;
  const ReconfigureNames reconfigure_;
  const std::shared_ptr<TfPoses> poses_;
};

}  // namespace lidard
