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

/// All that pipelines have to do with ROS: sinks for what they produce, poses from tf, and, once feed() is
/// called, what other nodes publish for them and changes of them. The same live, in replay and in the
/// drop-ins.
class RosSession : public RosConnection {
 public:
  /// See RosPost.
  using Post = std::function<void(std::function<void(Stamp received)> task)>;

  /// One pipeline does everything. Throws RosError.
  RosSession(const Config& config, const RosOptions& options) : RosSession(config, Config(), options) {}
  /// Two pipelines share the work: `clouds` as part_of() gives it.
  RosSession(const Config& planes, const Config& clouds, const RosOptions& options);
  ~RosSession();

  /// tf; must not be used after the session ended.
  TransformSource& poses();
  /// Lets messages of `topic:` and `packet_topic:` sensors, of the vehicle's motion and of
  /// dynamic_reconfigure reach the pipeline, which must outlive the session's use. `config` is that of the
  /// pipeline. To be called before start().
  /// `whole`: the configuration that `config` is a part of.
  void feed(const Config& config, const Config& whole, MessageReceiver& pipeline, Post post);
  /// Follows another configuration with all but the topics of sink(), see set_topics(). `parts` by lane, for
  /// the pipelines in the order of feed(). Throws RosError; then nothing changes.
  void change(const Config& whole, const std::array<Config, 2>& parts);

 private:
  struct Fed;
  void renew(Fed& fed, const Config& config, const Config& whole);

  const ReconfigureNames reconfigure_;
  const std::shared_ptr<TfPoses> poses_;
  std::vector<std::unique_ptr<Fed>> fed_;  // one for each pipeline
};

}  // namespace lidard
