// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "daemon/config/config.h"
#include "daemon/ros/output_items.h"
#include "daemon/ros/ros_connection.h"
#include "daemon/ros/ros_inputs.h"
#include "daemon/ros/tf_poses.h"

namespace lidard {

/// All that a pipeline has to do with ROS: a sink for what it produces, poses from tf, and, once feed() is
/// called, what other nodes publish for it and change of it. The same live, in replay and in the drop-ins.
class RosSession : public RosConnection {
 public:
  /// Throws RosError.
  RosSession(const Config& config, const RosOptions& options)
      : RosConnection(options, output_topics(config)),
        config_(config),
        reconfigure_(options.reconfigure),
        poses_(std::make_shared<TfPoses>()) {
    add(poses_);
  }

  /// tf; must not be used after the session ended.
  TransformSource& poses() { return *poses_; }
  /// Lets messages of `topic:` and `packet_topic:` sensors, of the vehicle's motion and of
  /// dynamic_reconfigure reach the pipeline, which must outlive the session's use. To be called before
  /// start().
  void feed(MessageReceiver& pipeline, const RosPost& post) {
    without_steps_ = std::make_unique<WithoutSteps>(pipeline);
    add(std::make_shared<RosInputs>(topic_sources(config_), post, *without_steps_));
    add(make_ros_motion(config_.vehicle, post, *without_steps_));
    add(make_ros_reconfigure(changeable_outputs(config_, reconfigure_), post, *without_steps_));
  }
  /// By how much the host's clock was set since the beginning. The pipeline reckons without steps, ROS with
  /// the host's clock. To be called by the pipeline's thread.
  void set_step(Span step) {
    if (without_steps_) without_steps_->step = step;
    poses_->set_step(step);
    RosConnection::set_step(step);
  }

 private:
  /// What comes in is stamped with the host's clock.
  struct WithoutSteps final : MessageReceiver {
    explicit WithoutSteps(MessageReceiver& receiver) : to(receiver) {}
    void packet_message(const std::string& sensor, const Packet& packet, Stamp received) override {
      Packet same = packet;
      same.arrival = packet.arrival - step;
      to.packet_message(sensor, same, received);
    }
    void scan_message(const std::string& sensor, PlanarScan& scan, Stamp received) override {
      scan.stamp = scan.stamp - step;
      to.scan_message(sensor, scan, received);
    }
    void cloud_message(const std::string& sensor, Cloud& cloud, Stamp received) override {
      cloud.stamp = cloud.stamp - step;
      to.cloud_message(sensor, cloud, received);
    }
    void pose_message(Stamp stamp, const Pose& pose, const std::string& child, Stamp received) override {
      to.pose_message(stamp - step, pose, child, received);
    }
    void turn_message(Stamp stamp, const Eigen::Vector3d& rates, const std::string& frame,
                      Stamp received) override {
      to.turn_message(stamp - step, rates, frame, received);
    }
    void speed_message(double speed) override { to.speed_message(speed); }
    std::string set_output(const OutputId& output, const OutputScanConfig& wanted) override {
      return to.set_output(output, wanted);
    }

    MessageReceiver& to;
    Span step{0};
  };

  const Config& config_;
  const ReconfigureNames reconfigure_;
  const std::shared_ptr<TfPoses> poses_;
  std::unique_ptr<WithoutSteps> without_steps_;
};

}  // namespace lidard
