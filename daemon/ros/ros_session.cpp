// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/ros_session.h"

#include "daemon/pipeline/pipeline.h"
#include "daemon/ros/output_items.h"
#include "daemon/ros/ros_inputs.h"

namespace lidard {

RosSession::RosSession(const Config& config, const RosOptions& options)
    : RosConnection(options, output_topics(config)),
      config_(config),
      reconfigure_(options.reconfigure),
      poses_(std::make_shared<TfPoses>()) {
  add(poses_);
}

void RosSession::feed(Pipeline& pipeline, const RosPost& post) {
  add(std::make_shared<RosInputs>(topic_sources(config_), post, pipeline));
  add(make_ros_motion(config_.vehicle, post, pipeline));
  add(make_ros_reconfigure(changeable_outputs(config_, reconfigure_), post, pipeline));
}

}  // namespace lidard
