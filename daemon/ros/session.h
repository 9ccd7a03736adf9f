// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/ros/connection.h"

namespace lidard {

class MessageReceiver;
class TfPoses;
class TransformSource;
struct TopicSource;

/// The pipelines' interface to ROS: sinks for frames, poses from tf, and, after feed(), messages of other
/// nodes and changes of outputs. The same live, in replay and in the drop-ins.
class RosSession : public RosConnection {
 public:
  /// See RosPost.
  using Post = std::function<void(std::function<void(Stamp received)> task)>;

  /// With one pipeline. Throws RosError.
  RosSession(const Config& config, const RosOptions& options) : RosSession(config, Config(), options) {}
  /// With two pipelines: `clouds` as of part_of().
  RosSession(const Config& planes, const Config& clouds, const RosOptions& options);
  ~RosSession();

  /// tf; must not be used after the session ended.
  TransformSource& poses();
  /// Passes messages of `topic:` and `packet_topic:` sensors, of the vehicle's motion and of
  /// dynamic_reconfigure to the pipeline, which must outlive the session's use. `config` is that of the
  /// pipeline. To be called before start(). `whole`: the complete configuration, of which `config` is a part.
  void feed(const Config& config, const Config& whole, MessageReceiver& pipeline, Post post);
  /// Applies another configuration, except the topics of sink(), see set_topics(). `parts`: for the pipelines
  /// in the order of feed(). Throws RosError; then nothing changes.
  void change(const Config& whole, const std::array<Config, 2>& parts);

 private:
  struct Fed;
  void renew(Fed& fed, const Config& config, const Config& whole);

  const ReconfigureNames reconfigure_;
  const std::shared_ptr<TfPoses> poses_;
  std::vector<std::unique_ptr<Fed>> fed_;  // one for each pipeline
};

}  // namespace lidard
