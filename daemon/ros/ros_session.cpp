// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/ros_session.h"

#include "daemon/config/output_topics.h"
#include "daemon/pipeline/pipeline.h"
#include "daemon/ros/output_items.h"
#include "daemon/ros/ros_inputs.h"
#include "daemon/ros/ros_motion.h"
#include "daemon/ros/ros_reconfigure.h"

namespace lidard {
RosHandlers RosSession::into(Pipeline& pipeline) const {
  RosHandlers into;
  into.scan = [&pipeline, this](const std::string& sensor, PlanarScan& scan, Stamp received) {
    scan.stamp = scan.stamp - step_;
    pipeline.scan_message(sensor, scan, received);
  };
  into.cloud = [&pipeline, this](const std::string& sensor, Cloud& cloud, Stamp received) {
    cloud.stamp = cloud.stamp - step_;
    pipeline.cloud_message(sensor, cloud, received);
  };
  into.packet = [&pipeline, this](const std::string& sensor, ByteView packet, Stamp arrival, Stamp received) {
    pipeline.packet_message(sensor, {packet, arrival - step_, {}, {}}, received);
  };
  into.pose = [&pipeline, this](Stamp stamp, const Pose& pose, const std::string& child, Stamp received) {
    pipeline.pose_message(stamp - step_, pose, child, received);
  };
  into.turn = [&pipeline, this](Stamp stamp, const Eigen::Vector3d& rates, const std::string& frame,
                                Stamp received) {
    pipeline.turn_message(stamp - step_, rates, frame, received);
  };
  into.speed = [&pipeline](double speed) { pipeline.speed_message(speed); };
  into.change = [&pipeline](const OutputId& output, const OutputScanConfig& wanted) {
    pipeline.set_output(output, wanted);
  };
  return into;
}

RosSession::RosSession(const Config& config, const RosOptions& options)
    : RosConnection(options, output_topics(config)),
      config_(config),
      reconfigure_(options.reconfigure),
      poses_(std::make_shared<TfPoses>()) {
  add(poses_);
}

void RosSession::feed(Pipeline& pipeline, const RosPost& post) {
  const RosHandlers handlers = into(pipeline);
  add(std::make_shared<RosInputs>(topic_sources(config_), post, handlers));
  add(std::make_shared<RosMotion>(config_.vehicle, post, handlers));
  add(std::make_shared<RosReconfigure>(changeable_outputs(config_, reconfigure_), post, handlers));
}

void RosSession::set_step(Span step) {
  step_ = step;
  poses_->set_step(step);
  RosConnection::set_step(step);
}

}  // namespace lidard
