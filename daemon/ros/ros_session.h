// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <atomic>
#include <memory>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/ros/output_items.h"
#include "daemon/ros/ros_connection.h"
#include "daemon/ros/ros_inputs.h"
#include "daemon/ros/tf_poses.h"

namespace lidard {

/// All that pipelines have to do with ROS: sinks for what they produce, poses from tf, and, once feed() is
/// called, what other nodes publish for them and change of them. The same live, in replay and in the
/// drop-ins.
class RosSession : public RosConnection {
 public:
  /// One pipeline does everything. Throws RosError.
  RosSession(const Config& config, const RosOptions& options) : RosSession(config, Config(), options) {}
  /// Two pipelines share the work: `clouds` as part_of() gives it.
  RosSession(const Config& planes, const Config& clouds, const RosOptions& options)
      : RosConnection(options, output_topics(planes), output_topics(clouds)),
        reconfigure_(options.reconfigure),
        poses_(std::make_shared<TfPoses>()) {
    add(poses_);
  }

  /// tf; must not be used after the session ended.
  TransformSource& poses() { return *poses_; }
  /// Lets messages of `topic:` and `packet_topic:` sensors, of the vehicle's motion and of
  /// dynamic_reconfigure reach the pipeline, which must outlive the session's use. `config` is that of the
  /// pipeline. To be called before start().
  /// `whole`: the configuration that `config` is a part of.
  void feed(const Config& config, const Config& whole, MessageReceiver& pipeline, const RosPost& post) {
    auto outputs = changeable_outputs(whole, reconfigure_);
    const auto is_foreign = [&](const ChangeableOutput& output) { return !has_output(config, output.id); };
    outputs.erase(std::remove_if(outputs.begin(), outputs.end(), is_foreign), outputs.end());
    WithoutSteps& receiver = *without_steps_.emplace_back(std::make_unique<WithoutSteps>(pipeline));
    add(std::make_shared<RosInputs>(topic_sources(config), post, receiver));
    add(make_ros_motion(config.vehicle, post, receiver));
    add(make_ros_reconfigure(std::move(outputs), post, receiver));
  }
  /// By how much the host's clock was set since the beginning. Pipelines reckon without steps, ROS with the
  /// host's clock.
  void set_step(Span step) {
    for (const auto& receiver : without_steps_) receiver->step = step;
    poses_->set_step(step);
    RosConnection::set_step(step);
  }

 private:
  static bool has_output(const Config& config, const OutputId& id) {
    const auto named = [&](const auto& entry) { return entry.name == id.entry; };
    return id.kind == OutputId::Kind::merged
               ? std::any_of(config.merged_scans.begin(), config.merged_scans.end(), named)
               : std::any_of(config.virtual_scans.begin(), config.virtual_scans.end(), named);
  }
  /// What comes in is stamped with the host's clock.
  struct WithoutSteps final : MessageReceiver {
    explicit WithoutSteps(MessageReceiver& receiver) : to(receiver) {}
    void packet_message(const std::string& sensor, const Packet& packet, Stamp received) override {
      Packet same = packet;
      same.arrival = packet.arrival - step.load();
      to.packet_message(sensor, same, received);
    }
    void scan_message(const std::string& sensor, PlanarScan& scan, Stamp received) override {
      scan.stamp = scan.stamp - step.load();
      to.scan_message(sensor, scan, received);
    }
    void cloud_message(const std::string& sensor, Cloud& cloud, Stamp received) override {
      cloud.stamp = cloud.stamp - step.load();
      to.cloud_message(sensor, cloud, received);
    }
    void pose_message(Stamp stamp, const Pose& pose, const std::string& child, Stamp received) override {
      to.pose_message(stamp - step.load(), pose, child, received);
    }
    void turn_message(Stamp stamp, const Eigen::Vector3d& rates, const std::string& frame,
                      Stamp received) override {
      to.turn_message(stamp - step.load(), rates, frame, received);
    }
    void speed_message(double speed) override { to.speed_message(speed); }
    std::string set_output(const OutputId& output, const OutputScanConfig& wanted) override {
      return to.set_output(output, wanted);
    }

    MessageReceiver& to;
    std::atomic<Span> step{Span(0)};
  };

  const ReconfigureNames reconfigure_;
  const std::shared_ptr<TfPoses> poses_;
  std::vector<std::unique_ptr<WithoutSteps>> without_steps_;  // one for each pipeline
};

}  // namespace lidard
