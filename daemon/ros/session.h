// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>

#include "daemon/config/config.h"
#include "daemon/ros/connection.h"

namespace lidard {

class TfPoses;
class TransformSource;

/// The pipelines' interface to ROS: sinks for frames, poses from tf, and, after feed(), messages of other
/// nodes and changes of outputs. The same live, in replay and in the drop-ins.
class RosSession : public RosConnection {
 public:
  /// Throws RosError.
  RosSession(const Config& config, const RosOptions& options);

  /// tf; must not be used after the session ended.
  TransformSource& poses();
  /// Passes messages of `topic:` and `packet_topic:` sensors, of the vehicle's motion and of
  /// dynamic_reconfigure to the pipelines. To be called before start().
  void feed(const Config& config, RosPost post);
  /// Applies another configuration, except Sink::set_topics(). Throws RosError; then nothing
  /// changes.
  void change(const Config& before, const Config& config);

 private:
  void renew(const Config* before, const Config& config);

  const ReconfigureNames names_;
  const SharedClockStep clock_step_;
  const std::shared_ptr<TfPoses> poses_;
  RosPost post_;
  std::shared_ptr<RosComponent> inputs_, motion_, reconfigure_, outline_;
};

}  // namespace lidard
